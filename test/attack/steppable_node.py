"""The tree node on a computer whose wall clock somebody sets while it runs.

    python test/attack/steppable_node.py FILE run --cell CELL ...

At SIGUSR1 its clock is as many seconds ahead of the real one as FILE says.
"""

from __future__ import annotations

import signal
import sys
import time
from pathlib import Path

from bt_orchestrator.cli.main import main

AHEAD = 'ahead_s'
"""The name of that file."""


def make_steppable(file: Path) -> None:
    """Let a file say how far this process's wall clock is ahead."""
    real = time.time
    ahead_s = 0.0

    def step(*_: object) -> None:
        nonlocal ahead_s
        ahead_s = float(file.read_text())

    time.time = lambda: real() + ahead_s
    signal.signal(signal.SIGUSR1, step)


if __name__ == '__main__':
    _file, *_words = sys.argv[1:]
    make_steppable(Path(_file))
    sys.exit(main(_words))
