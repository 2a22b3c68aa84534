"""Reading the record of an item from a journal."""

from __future__ import annotations

import json
from dataclasses import replace

from bt_orchestrator.model import events as e
from bt_orchestrator.model.records import Wanted
from bt_orchestrator.model.script import Script
from bt_orchestrator.report.account.planned import US
from bt_orchestrator.report.account.steady_time import SteadyTime
from bt_orchestrator.report.item.fold import ItemFold
from bt_orchestrator.report.item.history import ClockSet, ItemHistory
from bt_orchestrator.report.reading import Reading

BEFORE = 1000
"""So many events before the first of an item tell what was so when it came."""

AFTER = 50
"""So many after its last one tell what ended with it."""

_OF_ITEM = ('task.', 'item.', 'cycle.', 'hold.raised')
_OF_ORDER = (e.JobQueued.event, e.JobUpdated.event)


def item_history(reading: Reading, item: str) -> ItemHistory | None:
    """Return everything about an item; None: the journal has nothing of it."""
    job = item.rpartition('/')[0]
    place = _place(reading, item, job)
    if place is None:
        return None
    first, last = place
    fold = ItemFold(item, job, Scripts(reading).of_job)
    for event in reading.events(Wanted(job=job, events=_OF_ORDER, before_seq=first)):
        fold.follow(event)
    around = Wanted(after_seq=max(0, first - 1 - BEFORE))
    steady = _steady_time(reading, around, first)
    for event in map(steady.of, reading.events(around)):
        if event.seq > last and fold.history.ended is not None and event.seq > last + AFTER:
            break
        if not isinstance(event, e.OrderEvent) or event.seq > first:
            fold.follow(event)
    _note_steps(fold.history, steady)
    return fold.history if fold.is_known else None


def _steady_time(reading: Reading, around: Wanted, first: int) -> SteadyTime:
    """Return the time that goes on as the clock did at an event."""
    before = SteadyTime(around.after_seq)
    for event in reading.events(replace(around, before_seq=first + 1)):
        before.follow(event)
    return SteadyTime(around.after_seq, ahead_us=-before.ahead_of(first))


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


class Scripts:
    """The scripts that a journal has."""

    def __init__(self, reading: Reading) -> None:
        self._reading = reading
        self._of: dict[str, Script | None] = {}
        self._by_digest: dict[str, Script] | None = None

    def of_job(self, job: str) -> Script | None:
        """Return what a job ran, or would have run; None: it is not known."""
        if job not in self._of:
            wanted = Wanted(job=job, events=_OF_ORDER, newest_first=True)
            order = self._reading.first(wanted)
            digest = getattr(order, 'digest', '')
            self._of[job] = self._loaded().get(digest)
        return self._of[job]

    def _loaded(self) -> dict[str, Script]:
        if self._by_digest is None:
            loaded = self._reading.events(Wanted(events=(e.ScriptLoaded.event,)))
            self._by_digest = {
                one.digest: one.definition for one in loaded if isinstance(one, e.ScriptLoaded)
            }
        return self._by_digest
