"""The OPC UA server with a cell in virtual time behind it, in real-time pace and without ROS 2.

    .venv/jazzy/bin/python test/opcua_stand.py --port 4840

kill -USR1 PID switches the node off, and on again.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from patience import PATIENCE_S

if TYPE_CHECKING:
    from collections.abc import Iterator

    from web.stand_cell import StandCell

    from bt_orchestrator.extensions.opcua.server.server import OpcUaServer
    from bt_orchestrator.ports import EventStore


@contextmanager
def opcua_stand(
    folder: Path,
    *,
    port: int = 0,
    sections: int = 5,
    faults: Sequence[str] | None = (),
    speed: float = 20.0,
    store: EventStore | None = None,
    plain: str = '',
) -> Iterator[tuple[StandCell, OpcUaServer]]:
    """Serve a cell without encryption; the address has a user in it, who is an engineer.

    :param plain: why the server uses nothing of asyncua's inside; empty: it does
    """
    from web.stand_cell import StandCell

    from bt_orchestrator.store.memory import MemoryStore

    stand = StandCell(
        folder, store or MemoryStore(), sections=sections, faults=faults, speed=speed
    )
    with served(stand, port, plain) as server:
        yield stand, server


@contextmanager
def served(stand: StandCell, port: int = 0, plain: str = '') -> Iterator[OpcUaServer]:
    """Serve a cell that there is."""
    from fakes.opcua_access import access_in, with_login
    from fakes.shipped import REASONS, RECIPES, TREES

    from bt_orchestrator.extensions.opcua.server.bridge import Bridge, Sources
    from bt_orchestrator.extensions.opcua.server.server import OpcUaServer
    from bt_orchestrator.script.shifts.shifts_file import read_reasons

    class WithLogin(OpcUaServer):
        @property
        def address(self) -> str:
            return with_login(super().address)

    sources = Sources((TREES,), (RECIPES,), reasons=read_reasons(REASONS))
    bridge = Bridge(stand.node.name, stand.open_door, sources)
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        access = access_in(Path(folder), stand.node.name, port=port, insecure=True, plain=plain)
        server = WithLogin(bridge, access)
        stack.enter_context(server.running())
        assert server.wait_until_open(PATIENCE_S), 'the server did not open its port'
        if server.is_stopped:
            server.wait()  # raises why
        yield server


def main() -> int:
    """Serve until Ctrl-C."""
    args = _arguments()
    from stand_serving import serve

    from bt_orchestrator.base.stop_signals import StopSignals

    with (
        tempfile.TemporaryDirectory() as folder,
        StopSignals() as stop,
        opcua_stand(
            Path(folder),
            port=args.port,
            sections=args.sections,
            faults=args.fail,
            speed=args.speed,
        ) as (stand, server),
    ):
        serve(stand, server, stop)
    return 0


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--port', type=int, default=4840)
    parser.add_argument('--sections', type=int, default=5, help='5, 20, 100 …')
    parser.add_argument('--fail', action='append', help='COMPONENT.FAULT; default: a hold')
    parser.add_argument('--speed', type=float, default=1.0)
    return parser.parse_args()


if __name__ == '__main__':
    sys.path.insert(0, str(Path(__file__).parent))
    sys.exit(main())
