"""Whether the line waits only for its source or its sink (semantics 7.2)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from bt_orchestrator.base.deadlines import has_come
from bt_orchestrator.engine.runtime.ledger import Ledger
from bt_orchestrator.model.events import TaskKey
from bt_orchestrator.model.state import CellState
from bt_orchestrator.model.stop_reason import StopReason
from bt_orchestrator.model.words import sentence

SUSPEND_AFTER_S = 1.0
"""How long the line has to wait before it counts: most components report busy for a moment after a
task, which is not starvation."""


class Starved(NamedTuple):
    """The end of the line that is waited for."""

    reason: StopReason
    words: str


class Starvation:
    """Measures how long the line waits for its source or sink."""

    def __init__(self, ledger: Ledger) -> None:
        self._ledger = ledger
        self._waited_for: Starved | None = None
        self._since = 0.0

    def look(self, unready: Sequence[TaskKey]) -> Starved | None:
        """Say for what the line has been waiting long enough; None: it has not.

        :param unready: tasks that wait for their component while nothing else can go on
        """
        now = self._ledger.steady
        found = find(self._ledger.state, unready) if unready else None
        if found != self._waited_for:
            self._waited_for, self._since = found, now
        if found is None:
            return None
        due = self._since + SUSPEND_AFTER_S
        if has_come(due, now):
            return found
        self._ledger.wake_at(due)
        return None


def find(state: CellState, unready: Iterable[TaskKey]) -> Starved | None:
    """Return the end of the line that is waited for; of both, the sink (downstream first, 4.4)."""
    found = [one for one in (_at_an_end(state, key) for key in unready) if one is not None]
    blocked = [one for one in found if one.reason is StopReason.BLOCKED]
    return next(iter([*blocked, *found]), None)


def _at_an_end(state: CellState, key: TaskKey) -> Starved | None:
    """Return the end of the line where a task waits; None: between, or in initialization."""
    task = state.task(key)
    if task is None or key.job is None or key.section is None:
        return None
    script = state.script(key.job)
    at_source, at_sink = (key.section == end for end in (script.source, script.sink))
    if at_source and at_sink:
        at_source = state.slot(key.section) is None  # nothing is placed yet
    if not at_source and not at_sink:
        return None
    reason = StopReason.STARVED if at_source else StopReason.BLOCKED
    if state.readings[task.component].ready:
        return None  # it waits because of a fault, not for material
    topic = state.cell.components[task.component].state
    return Starved(reason, sentence('starved', task=key, topic=topic))
