"""The page with a cell in virtual time behind it, in real-time pace and without ROS 2.

    .venv/jazzy/bin/python test/web/stand.py --port 8123 --sections 20

kill -USR1 PID switches the node off, and on again.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

PORT = 8123


def main() -> int:
    """Serve until Ctrl-C."""
    args = _arguments()
    sys.path.insert(0, str(Path(__file__).parents[1]))
    from stand_serving import serve
    from web.stand_page import stand_page

    from bt_orchestrator.base.stop_signals import StopSignals

    with tempfile.TemporaryDirectory() as folder, StopSignals() as stop:
        stand, server = stand_page(Path(folder), args)
        with server.running():
            serve(stand, server, stop)
    return 0


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--port', type=int, default=PORT)
    parser.add_argument('--host', default='127.0.0.1')
    parser.add_argument('--sections', type=int, default=5, help='5, 20, 100 …')
    parser.add_argument('--fail', action='append', help='COMPONENT.FAULT; none: no fault')
    parser.add_argument('--speed', type=float, default=1.0)
    parser.add_argument('--jobs', type=int, default=6)
    parser.add_argument('--quantity', type=int, default=8, help='of each job')
    parser.add_argument(
        '--login',
        action='store_true',
        help='commands need a login: ann, eve (engineer), mes or vic, with the password of '
        'fakes/quick_users.py; otherwise this computer is trusted',
    )
    return parser.parse_args()


if __name__ == '__main__':
    sys.exit(main())
