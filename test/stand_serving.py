"""How the stands end: the OPC UA server and the page before a cell in virtual time."""

from __future__ import annotations

import os
import signal
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from web.stand_cell import StandCell

    from bt_orchestrator.base.stop_signals import StopSignals
    from bt_orchestrator.ports.doors.server_thread import ServerThread


def serve(stand: StandCell, server: ServerThread, stop: StopSignals) -> None:
    """Say where it is, and serve until Ctrl-C; USR1 switches the node off, and on again."""
    signal.signal(signal.SIGUSR1, lambda *_: stand.switch())
    sys.stdout.write(f'process {os.getpid()}, {server.address}\n')
    sys.stdout.flush()
    stop.notify(server.stop)
    server.wait()
