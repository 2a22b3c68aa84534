"""Past states of a cell: the state from the journal, the reasons from the engine's tree."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence

from bt_orchestrator.base.errors import NotKept
from bt_orchestrator.engine.runtime.ledger import Ledger
from bt_orchestrator.engine.runtime.overview import Overview
from bt_orchestrator.engine.tree.compile import CellTree
from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.codec import digest, from_record
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.model.keeping.snapshot import state_from_plain, state_to_plain
from bt_orchestrator.model.requests import is_remark
from bt_orchestrator.model.state import CellState
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.ports import Goal, Records
from bt_orchestrator.sim.gateway import VirtualClock
from bt_orchestrator.view.report.past_state import state_at

MOST_TICKS = 1000
"""More than this is a defect of the rules, and not a moment in the middle of a settle."""


class JournalPast:
    """Looks back through a journal. Implements `ports.Past`."""

    def __init__(self, cell: Cell, records: Records) -> None:
        """Look back.

        :param cell: as its file said at those moments
        """
        self._cell = cell
        self._records = records

    def status_at(self, seq: int, at: float | None = None) -> CellStatus:
        """Return how the cell stood after an event, and what it waited for.

        A standstill is told as in a status of that moment. At the event itself it is told where
        it lasted for long enough, by the time of the next event.

        Whether servers were there, and what goals had fed back, is not in the journal: all are
        shown as there, and no feedback.

        :raises NotKept: the event is not in the journal, or it was another cell then
        """
        rest_s: float | None = None

        def before(state: CellState, event: e.Event) -> None:
            nonlocal rest_s
            rest_s = _rest(state.time if rest_s is None else rest_s, event, state)

        state = state_at(self._records, self._cell, seq, before)
        if state.cell_digest != digest(self._cell):
            raise NotKept(
                f'at event {seq} the cell file was another one than that of cell '
                f'{self._cell.name} is now: name the file as it was then'
            )
        engine = StillEngine(state)
        try:
            moment = state.time if at is None else max(at, state.time)
            until = self._next_event(seq) if at is None else moment
            return Overview(engine).status(moment, until_s=until, rest_s=rest_s)
        finally:
            engine.close()

    def _next_event(self, seq: int) -> float:
        """Return the time of the event after another one; infinity: there is none."""
        page = self._records.page(Wanted(after_seq=seq), 1)
        return next(
            (from_record(json.loads(record.text)).time for record in page.records), math.inf
        )


def _rest(rest_s: float, event: e.Event, state: CellState) -> float:
    """Return since when nothing happens on the line, after an event that comes to a state."""
    if isinstance(event, e.ClockStepped):
        return rest_s + event.seconds
    if isinstance(event, e.ComponentStateChanged):
        known = state.readings[event.component]
        return rest_s if known.ready == event.ready else event.time
    is_remark_of = isinstance(event, e.OperatorDecided) and is_remark(event.answer)
    is_refusal = isinstance(event, (e.OperatorRefused, e.RequestRefused, e.RequestSigned))
    return rest_s if is_remark_of or is_refusal else event.time


class _Nobody:
    """Placeholder for robots: no requests are sent."""

    def available(self, component: str) -> bool:  # noqa: ARG002 - the gateway's
        """Return True: the past value is not known."""
        return True

    def rivals(self, component: str) -> Sequence[str]:  # noqa: ARG002 - the gateway's
        """Return nothing: contests are in the state."""
        return ()

    def server(self, component: str) -> str | None:  # noqa: ARG002 - the gateway's
        """Return None: nothing is sent."""
        return None

    def goal(self, goal_id: str) -> Goal | None:  # noqa: ARG002 - that of flights
        """Return None: feedback is not in the journal."""
        return None


class StillEngine:
    """The engine at one moment, without actions: its tree shows the waits.

    The tree works on a copy of the state. In the middle of a settle it runs to the settle's end,
    because reasons are valid only then; the data shown stays that of the moment.
    """

    def __init__(self, state: CellState) -> None:
        """Tick the tree of a state until nothing changes."""
        self.state = state
        self.gateway = _Nobody()
        self.flights = self.gateway
        self.broken: str | None = None
        self.disk_wait = ''
        plain = json.loads(json.dumps(state_to_plain(state)))
        copied = state_from_plain(state.cell, plain)
        clock = VirtualClock(state.time)
        self._ledger = Ledger(
            copied,
            clock,
            lambda kind: self.tree.notices(kind),  # noqa: PLW0108 - the tree is made below
            lambda: 'none',
            self.gateway,
            lambda: None,
        )
        self.tree = CellTree(self._ledger, '/past')
        for _ in range(MOST_TICKS):
            self.tree.tick()
            if not self.tree.is_due:
                return
        raise AssertionError(f'the tree still changes the state after {MOST_TICKS} ticks')

    def close(self) -> None:
        """Give the tree up."""
        self._ledger.close()
        self.tree.close()
