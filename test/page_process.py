"""The operator page of a node in a process of its own, for tests."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from urllib.request import urlopen

from program_process import PATIENCE_S
from served_process import ServedProcess


class PageProcess(ServedProcess):
    """The page on a port of its own."""

    def __init__(self, folder: Path, node: str, options: Sequence[str] = ()) -> None:
        """Start it; `wait_ready` waits for it.

        :param options: of the verb, on top of node, port and users
        """
        super().__init__(folder, 'page', node, options)

    @property
    def readers(self) -> int:
        """How many streams it has open."""
        with urlopen(f'http://127.0.0.1:{self.port}/healthz', timeout=PATIENCE_S) as answer:
            return int(json.load(answer)['readers'])
