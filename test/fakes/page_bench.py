"""The page without a network: people, guards, commands, and a cell in virtual time behind them."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from contract.link_bench import folder_with_files
from fakes.action_types import FakeActionTypes
from fakes.browser import Answered, Browser
from fakes.quick_users import PASSWORD, write_users
from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import Response

from bt_orchestrator.base.errors import NodeUnreachable
from bt_orchestrator.extensions.page.web import commands, me
from bt_orchestrator.extensions.page.web.access import Access
from bt_orchestrator.extensions.page.web.endpoint import HANDLERS, Endpoint, Json, body_of, routes
from bt_orchestrator.extensions.page.web.guards import GuardMiddleware
from bt_orchestrator.extensions.page.web.people import People
from bt_orchestrator.model.by import Role
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.requests import Asked
from bt_orchestrator.ports import EventPage
from bt_orchestrator.ports.doors.tickets import Tickets
from bt_orchestrator.script.cell_file import read_cell
from bt_orchestrator.sim.virtual_link import VirtualLink, VirtualNode
from bt_orchestrator.store.memory import MemoryStore

ROLES = {'ann': Role.OPERATE, 'eve': Role.ENGINEER, 'mes': Role.MES, 'vic': Role.VIEW}
"""Users of the page, with their roles."""


class PeopleBench:
    """A page with nothing but people, and a clock that is set."""

    def __init__(self, folder: Path, **options: Any) -> None:
        """Make a page; options are those of `Access`."""
        self.now = 1000.0
        self.users = write_users(folder / 'users.yaml', ROLES)
        self.people = People(Access(self.users, **options), lambda: self.now)
        self.loop = asyncio.new_event_loop()
        self.app = self.make_app()

    def make_app(self) -> Starlette:
        """Return the application."""
        return Starlette(
            routes=routes((*me.endpoints(self.people), *self.endpoints())),
            middleware=[Middleware(GuardMiddleware, people=self.people)],
            exception_handlers=HANDLERS,
        )

    def endpoints(self) -> Sequence[Endpoint]:
        """Return what else there is."""
        return (
            Endpoint('GET', '/api/look', _look, ''),
            Endpoint('POST', '/api/echo', _echo, ''),
            Endpoint('GET', '/api/fail', _fail, ''),
            Endpoint('GET', '/static/app.js', _look, ''),
        )

    def browser(self, **about: Any) -> Browser:
        """Return a browser that nobody logged in with."""
        return Browser(self.app, self.loop, **about)

    def logged_in(self, name: str, **about: Any) -> Browser:
        """Return a browser with a session."""
        browser = self.browser(**about)
        answer = log_in(browser, name)
        assert answer.status == 200, answer.body
        return browser

    def close(self) -> None:
        """Put everything away."""
        self.people.close()
        self.loop.close()


class CellBench(PeopleBench):
    """A page of a cell of two sections, whose breaker fails."""

    def __init__(self, folder: Path, **options: Any) -> None:
        """Make a page, and switch the cell's node on."""
        types = FakeActionTypes()
        cell, _ = folder_with_files(folder)
        self.node = VirtualNode(read_cell(cell, types), types, [folder])
        self.store = MemoryStore()
        self.node.switch_on(self.store)
        self.doors = FakeDoors(self.node)
        self.tickets = self.make_tickets()
        super().__init__(folder, **options)

    def endpoints(self) -> Sequence[Endpoint]:
        """Return the commands."""
        return (*super().endpoints(), *commands.endpoints(self.tickets))

    def make_tickets(self) -> Tickets:
        """Return what a page knows of commands when it starts."""
        return Tickets(self.doors, lambda: self.doors.newest, lambda: self.now)

    def restart_page(self) -> None:
        """Start the page anew: it has forgotten everything but its users."""
        self.people = People(self.people.access, lambda: self.now)
        self.tickets = self.make_tickets()
        self.app = self.make_app()

    @property
    def journal(self) -> list[Event]:
        """All events."""
        return list(self.store.read())

    def of(self, *names: str) -> list[Any]:
        """Return the events with these names."""
        return [event for event in self.journal if event.event in names]

    @property
    def commands(self) -> list[Any]:
        """What is on record of commands."""
        return self.of('operator.decided', 'operator.refused', 'request.refused')


class FakeDoors:
    """The doors of a page, in one thread, with answers that can be lost."""

    def __init__(self, node: VirtualNode) -> None:
        self._link = VirtualLink(node)
        self._node = node
        self.loses_answers = False
        self.is_silent = False
        self.asked: list[Asked] = []
        self.gate: asyncio.Event | None = None
        """Answers wait for it."""

    @property
    def newest(self) -> int:
        """The last event."""
        return self._link.status().seq if self._node.is_on else 0

    async def ask(self, asked: Asked) -> Answer:
        """Ask the cell."""
        self.asked.append(asked)
        answer = self._link.ask(asked)
        if self.gate is not None:
            await self.gate.wait()
        if self.loses_answers:
            raise NodeUnreachable('/bt_orchestrator did not answer within 5 s')
        return answer

    async def events_after(self, seq: int, most: int = 0) -> EventPage:
        """Read the journal."""
        if self.is_silent:
            raise NodeUnreachable('/bt_orchestrator is silent')
        return self._link.events_after(seq, most)


def log_in(browser: Browser, name: str, password: str = PASSWORD) -> Answered:
    """Log in."""
    return browser.post('/api/login', {'name': name, 'password': password})


async def _look(request: Request) -> Response:
    session = request.state.session
    return Json({'who': session.name if session else ''})


async def _echo(request: Request) -> Response:
    return Json({'body': await body_of(request)})


async def _fail(_: Request) -> Response:
    raise RuntimeError('secrets of the page')
