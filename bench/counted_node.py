"""The program, which at SIGUSR1 writes how many of rclpy's futures it holds."""

from __future__ import annotations

import gc
import os
import signal
import sys
from pathlib import Path

from rclpy.task import Future, Task

from bt_orchestrator.cli.main import main

FILE = 'BENCH_FUTURES'
"""Environment variable: where to write it."""


def count(*_: object) -> None:
    """Write the number of futures that are no tasks of the executor's turn."""
    file = Path(os.environ[FILE])
    futures = [
        obj for obj in gc.get_objects() if isinstance(obj, Future) and not isinstance(obj, Task)
    ]
    part = file.with_suffix('.part')
    part.write_text(str(len(futures)))
    part.rename(file)


if __name__ == '__main__':
    signal.signal(signal.SIGUSR1, count)
    sys.exit(main())
