"""What the engine told of the waits of items in a run, against what its journal tells of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import pairwise
from math import inf
from typing import TYPE_CHECKING, TypeAlias

from bt_orchestrator.model.events import TaskKey
from bt_orchestrator.model.state import CellState, ItemState
from bt_orchestrator.model.wait import Wait
from bt_orchestrator.model.waits.starting import Seen
from bt_orchestrator.model.waits.waiting import Waiting, at_bottom, of_item
from bt_orchestrator.view.report.item.waits import ItemWaits

if TYPE_CHECKING:
    from fakes.virtual_run import VirtualRun

Told = list[tuple[Wait, tuple[TaskKey, ...]]]
ToldWaits: TypeAlias = Mapping[str, Told]
"""By item."""

LEAST_S = 1e-6
"""The clock counts nanoseconds, and events have the time of a float."""


def told_of(state: CellState, item: ItemState, seen: Seen) -> Told:
    """Return what is told of an item now."""
    waiting = tuple(of_item(state, item, seen))
    return [(at_bottom(state, entry.wait, seen), entry.tasks) for entry in waiting]


class _Collected(ItemWaits):
    """Keeps what is told of each stretch of time."""

    def __init__(self, item: str, state: CellState) -> None:
        super().__init__(item, state)
        self.stretches: list[tuple[float, float, Told]] = []

    def _note(self, start: float, end: float, waits: Iterable[Waiting]) -> None:
        self.stretches.append((start, end, [(entry.wait, entry.tasks) for entry in waits]))


def recorded_as_told(run: VirtualRun) -> int:
    """Fail unless the journal tells of each item, at each moment, what the engine told.

    Returns how often a wait was told.
    """
    number, events = 0, list(run.store.read())
    times = sorted(run.told_waits)
    for item in sorted({item for by_item in run.told_waits.values() for item in by_item}):
        collected = _Collected(item, CellState(run.sim.orchestrator.state.cell))
        for event in events:
            collected.follow(event)
        assert collected.unknown_since == inf
        stretches = iter(collected.stretches)
        end, waits = 0.0, Told()
        for since, until in pairwise(times):
            middle = (since + until) / 2
            if until - since < LEAST_S or middle > events[-1].time:
                continue
            while middle > end:
                _, end, waits = next(stretches)
            expected = run.told_waits[since].get(item, [])
            assert waits == expected, (item, since, until)
            number += len(expected)
    return number
