"""The log of all waits in a virtual run, with exact times; equal reasons can be summed up.

Virtual time does not advance inside a settle, and nothing changes between two settles. So one look
after each settle finds every wait, with its exact beginning and end.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from bt_orchestrator.model.events import TaskKey
from bt_orchestrator.model.state import CellState
from bt_orchestrator.model.wait import BELT, INITIALIZATION, PartWait, Wait, WaitKind

_Row = tuple[str, str]
"""Whether it is a part of the cell or a component, and its name."""

_PART, _COMPONENT = 'part', 'component'


class WaitSpan(NamedTuple):
    """From when to when something waited, and for what."""

    start_s: float
    end_s: float
    causes: tuple[Cause, ...]
    """More than one: for all of them at once."""


@dataclass(frozen=True)
class Waits:
    """All waits of a run."""

    spans: Mapping[_Row, Sequence[WaitSpan]] = field(default_factory=dict)

    def of_section(self, number: int) -> Sequence[WaitSpan]:
        """Return when a section neither worked nor had a goal in flight."""
        return self.spans.get((_PART, f'section {number}'), ())

    def of_component(self, name: str) -> Sequence[WaitSpan]:
        """Return when a component had a task to begin, and could not."""
        return self.spans.get((_COMPONENT, name), ())

    @property
    def of_initialization(self) -> Sequence[WaitSpan]:
        """When initialization could not go on."""
        return self.spans.get((_PART, INITIALIZATION), ())

    @property
    def of_belt(self) -> Sequence[WaitSpan]:
        """When the belt could not move."""
        return self.spans.get((_PART, BELT), ())


NO_WAITS = Waits()
"""Of a run whose waits were not recorded."""


class WaitLog:
    """Records all waits each time it is shown the cell."""

    def __init__(self) -> None:
        self._spans: dict[_Row, list[WaitSpan]] = defaultdict(list)
        self._open: dict[_Row, tuple[float, tuple[Cause, ...]]] = {}

    def look(self, state: CellState, waits: Sequence[PartWait], now_s: float) -> None:
        """Note waits that begin or end now."""
        current = _causes(state, waits)
        for row in [row for row, (_, causes) in self._open.items() if current.get(row) != causes]:
            self._close(row, now_s)
        for row, causes in current.items():
            self._open.setdefault(row, (now_s, causes))

    def end(self, now_s: float) -> Waits:
        """Return everything up to now."""
        for row in list(self._open):
            self._close(row, now_s)
        return Waits(dict(self._spans))

    def _close(self, row: _Row, now_s: float) -> None:
        start_s, causes = self._open.pop(row)
        if now_s > start_s:
            self._spans[row].append(WaitSpan(start_s, now_s, causes))


def _causes(state: CellState, waits: Sequence[PartWait]) -> dict[_Row, tuple[Cause, ...]]:
    """Return what each row waits for; those that work are left out."""
    belt = [wait.wait for wait in waits if wait.part == BELT]
    working = {(_PART, _part(key)) for key in state.running}
    by_row: dict[_Row, dict[Cause, None]] = defaultdict(dict)
    for wait in waits:
        cause = cause_of(wait.wait, belt)
        for row in _rows(wait):
            by_row[row][cause] = None
    busy = {(_COMPONENT, name) for name, key in state.reserved.items() if key in state.running}
    idle = by_row.keys() - busy - working
    return {row: tuple(causes) for row, causes in by_row.items() if row in idle}


def _part(key: TaskKey) -> str:
    if key.job is None:
        return BELT
    return INITIALIZATION if key.section is None else f'section {key.section}'


def _rows(wait: PartWait) -> Iterable[_Row]:
    yield _PART, wait.part
    for component in wait.wait.components:
        yield _COMPONENT, component


# Reasons of waits without item ids: equal waits can be summed up.


class Cause(NamedTuple):
    """The cause of a wait."""

    kind: WaitKind
    text: str


def cause_words(causes: Sequence[Cause]) -> str:
    """Name what is waited for, all of it at once."""
    return ' and '.join(cause.text for cause in causes)


def kind_words(causes: Sequence[Cause]) -> str:
    """Return the kinds of waits, joined by +, each once."""
    return '+'.join(dict.fromkeys(cause.kind.value for cause in causes))


_TEXTS = {
    WaitKind.BELT: 'the belt, which moves',
    WaitKind.ITEM: 'an item',
    WaitKind.FLAG: 'flag {name}',
    WaitKind.ZONE: 'zone {name}',
    WaitKind.COMPONENT: '{name}, busy elsewhere',
    WaitKind.READINESS: '{name} to be ready',
    WaitKind.OUT_OF_SERVICE: '{name}, out of service',
    WaitKind.INITIALIZATION: 'initialization {name}',
    WaitKind.HOLD: 'an answer to a hold',
    WaitKind.PAUSE: 'the cell to be resumed',
    WaitKind.RETRY_DELAY: 'the delay before a retry',
    WaitKind.CELL_STATE: 'the cell, which is {name}',
}


def cause_of(wait: Wait, belt: Sequence[Wait]) -> Cause:
    """Return the cause of a wait.

    :param belt: what the belt waits for now; nothing while it moves
    """
    if wait.kind is WaitKind.TURN:
        return Cause(wait.kind, f'the {_turns(wait.sections)}')
    if wait.kind is WaitKind.JOB:
        return Cause(wait.kind, _job(wait))
    if wait.kind is WaitKind.BELT and belt:
        return Cause(wait.kind, f'the belt: {cause_of(belt[0], ()).text.removeprefix("the ")}')
    return Cause(wait.kind, _TEXTS[wait.kind].format(name=wait.name))


def _turns(sections: Sequence[int]) -> str:
    *others, last = map(str, sections)
    if not others:
        return f'turn of section {last}'
    return f'turns of sections {", ".join(others)} and {last}'


def _job(wait: Wait) -> str:
    if not wait.sections:
        return 'a job'
    return f'section {wait.sections[0]} to finish {wait.name}'
