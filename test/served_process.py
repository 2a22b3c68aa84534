"""A server of a node for people or programs outside, in a process of its own, for tests."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from held_port import HeldPort
from program_process import ProgramProcess

from bt_orchestrator.model.by import Role
from bt_orchestrator.script.users.file import UsersFile

PASSWORD = 'a long password of tests'
"""Of every user; there is one of each role, whose name is that of the role."""


class ServedProcess:
    """A verb on a port of its own, which it keeps when it is started again. Ends in `close`."""

    def __init__(self, folder: Path, verb: str, node: str, options: Sequence[str] = ()) -> None:
        """Start it; `wait_ready` waits for it.

        :param options: of the verb, on top of node, port and users
        """
        self.folder = folder
        self._held = HeldPort()
        self.port = self._held.number
        self.users = folder / 'users.yaml'
        if not self.users.exists():
            _add_users(self.users)
        words = [verb, '--node', node, '--port', str(self.port), '--users', str(self.users)]
        self._words = [*words, *options]
        self._started = 0
        self.process = self.start()

    def start(self) -> ProgramProcess:
        """Start it again, which must be gone."""
        self._started += 1
        name = f'{self._words[0]}_{self._started}'
        self.process = ProgramProcess(self._words, self.folder, name)
        return self.process

    def wait_ready(self) -> None:
        """Wait until it serves."""
        self.process.wait_ready()

    def kill_and_restart(self) -> None:
        """Kill it as kill -9 does, and start it again."""
        self.process.kill()
        self.start()
        self.wait_ready()

    def stop(self) -> None:
        """End it as Ctrl-C does, and fail unless it ends well."""
        assert self.process.stop() == 0, self.process.errors
        self.process.assert_clean()

    def close(self) -> None:
        """Leave nothing behind."""
        self.process.kill()
        self._held.close()


def _add_users(path: Path) -> None:
    """Make one user of each role."""
    users = UsersFile(path)
    for role in Role:
        users.add(role.value, role, PASSWORD)
