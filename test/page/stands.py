"""The page of a cell in virtual time, in real-time pace: for what needs no ROS 2."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from fakes.operator import engineer
from web.stand_cell import StandCell
from web.stand_page import stand_page

from bt_orchestrator.extensions.page.web.server import PageServer
from bt_orchestrator.model.codec import to_record
from bt_orchestrator.model.requests import ask


class Stand:
    """A cell, and the server of its page."""

    def __init__(self, cell: StandCell, server: PageServer) -> None:
        self.cell = cell
        self.server = server

    @property
    def port(self) -> int:
        """Where the page is."""
        return self.server.port

    def happened(self, kind: str) -> list[dict[str, Any]]:
        """Return the records of all events of a kind."""
        with self.cell.lock:
            events = list(self.cell.store.read())
        return [record for event in events if (record := to_record(event))['event'] == kind]

    def ask(self, request: str, reason: str = 'a test', **arguments: object) -> None:
        """Ask the cell for something as an engineer; it must be accepted."""
        answer = self.cell.ask(ask(request, engineer('Ann', 'the stand', reason), **arguments))
        assert answer.accepted, answer


@contextmanager
def stand(
    folder: Path,
    *,
    sections: int = 5,
    jobs: int = 6,
    quantity: int = 8,
    fail: list[str] | None = None,
    speed: float = 4.0,
    login: bool = False,
) -> Iterator[Stand]:
    """Run one; a fault gives it a hold after some seconds.

    :param fail: COMPONENT.FAULT of other faults
    """
    options = argparse.Namespace(
        sections=sections,
        fail=fail,
        speed=speed,
        jobs=jobs,
        quantity=quantity,
        login=login,
        host='127.0.0.1',
        port=0,
    )
    cell, server = stand_page(folder, options)
    with server.running():
        yield Stand(cell, server)
