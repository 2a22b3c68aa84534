"""Reading the record of an item from a journal."""

from __future__ import annotations

import json

from bt_orchestrator.base.errors import NotKept
from bt_orchestrator.model import events as e
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.model.state import CellState
from bt_orchestrator.view.report.account.planned import US
from bt_orchestrator.view.report.account.steady_time import SteadyTime
from bt_orchestrator.view.report.item.fold import ItemFold
from bt_orchestrator.view.report.item.history import ClockSet, ItemHistory
from bt_orchestrator.view.report.past_state import MISFITS, cell_at, state_at
from bt_orchestrator.view.report.reading import Reading

AFTER = 50
"""So many after its last one tell what ended with it."""

_OF_ITEM = (
    *('task.', 'item.', 'cycle.', 'hold.raised'),
    *('job.paused', 'job.resumed', 'job.stopping'),  # of a first piece
)
_OF_ORDER = (e.JobQueued.event, e.JobUpdated.event)


def item_history(reading: Reading, item: str) -> ItemHistory | None:
    """Return everything about an item; None: the journal has nothing of it."""
    job = item.rpartition('/')[0]
    place = _place(reading, item, job)
    if place is None:
        return None
    first, last = place
    fold, steady = ItemFold(item, job, _state_before(reading, first)), SteadyTime(first - 1)
    for event in reading.events(Wanted(job=job, events=_OF_ORDER, before_seq=first)):
        fold.note_order(event)
    for event in map(steady.of, reading.events(Wanted(after_seq=first - 1))):
        if event.seq > last + AFTER and fold.history.ended is not None:
            break
        fold.follow(event)
    _note_steps(fold.history, steady)
    return fold.history if fold.is_known else None


def _state_before(reading: Reading, seq: int) -> CellState | None:
    """Return the state before an event; None: the journal does not have it, or not the cell."""
    try:
        cell = cell_at(reading, seq - 1)
        if cell is None or seq == 1:
            return None if cell is None else CellState(cell)
        return state_at(reading.records, cell, seq - 1)
    except (NotKept, *MISFITS):
        return None


def _note_steps(history: ItemHistory, steady: SteadyTime) -> None:
    begun, ended = history.started, history.ended
    for step in steady.steps:
        time = step.at_us / US
        if begun is not None and begun < time and (ended is None or time <= ended):
            history.clock_set.append(ClockSet(time, step.by_us / US))


def _place(reading: Reading, item: str, job: str) -> tuple[int, int] | None:
    """Return the first and the last event that name an item."""
    name = json.dumps(item, ensure_ascii=False)
    begin = reading.first(Wanted(job=job, events=_OF_ORDER[:1], newest_first=True))
    wanted = Wanted(job=job, events=_OF_ITEM, after_seq=begin.seq if begin else 0)
    seqs = [
        event.seq
        for event in reading.events(wanted, lambda text: name in text or '\\' in text)
        if getattr(event, 'item', None) == item
    ]
    return (seqs[0], seqs[-1]) if seqs else None
