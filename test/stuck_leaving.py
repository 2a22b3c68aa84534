"""The program, whose middleware never lets go of it.

python test/stuck_leaving.py VERB ...
"""

from __future__ import annotations

import sys
import threading

import rclpy

from bt_orchestrator.base import stop_signals
from bt_orchestrator.cli.main import main


def hang(**_: object) -> None:
    """Stand for destructors that wait for each other."""
    threading.Event().wait()


if __name__ == '__main__':
    stop_signals.LEAVING_S = 1.0
    rclpy.shutdown = rclpy.try_shutdown = hang
    sys.exit(main(sys.argv[1:]))
