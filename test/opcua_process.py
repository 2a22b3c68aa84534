"""The OPC UA server of a node in a process of its own, for tests."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from program_process import ProgramProcess
from served_process import ServedProcess


class OpcUaProcess(ServedProcess):
    """The server on a port of its own, with its certificates in the folder `pki`."""

    def __init__(self, folder: Path, node: str, options: Sequence[str] = ()) -> None:
        """Start it; `wait_ready` waits for it.

        :param options: of the verb, on top of node, port, users and certificates
        """
        self.pki = folder / 'pki'
        super().__init__(folder, 'opcua', node, ['--pki', str(self.pki), *options])

    @property
    def endpoint(self) -> str:
        """Its address for clients."""
        return f'opc.tcp://127.0.0.1:{self.port}'

    def trust(self, thumbprint: str = '') -> str:
        """Trust a client that was refused, or list what was; returns what is printed."""
        words = ['opcua', 'trust', *filter(None, [thumbprint]), '--pki', str(self.pki)]
        verb = ProgramProcess(words, self.folder, 'verb_trust')
        assert verb.wait() == 0, verb.errors
        return verb.output
