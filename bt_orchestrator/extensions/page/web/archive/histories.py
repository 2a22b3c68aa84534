"""The last work of a section or of a component, and the record of one item."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import islice
from statistics import median
from typing import Any

from bt_orchestrator.extensions.page.web.archive.archive import Look, each, event_of, events
from bt_orchestrator.extensions.page.web.wording import said_in_each
from bt_orchestrator.model import events as e
from bt_orchestrator.model.events import ClockStepped, Event
from bt_orchestrator.model.keeping.records import Record, Wanted
from bt_orchestrator.model.status import CellDescription
from bt_orchestrator.view.report.item.history import plain_item
from bt_orchestrator.view.report.item.reader import item_history
from bt_orchestrator.view.report.reading import Reading
from bt_orchestrator.view.report.work_history import FOLLOWED, MOST_CYCLES, Cycle, WorkFold

MOST_RECORDS = 20_000
"""So many of the last records are looked at."""


@dataclass(frozen=True)
class Subject:
    """A section, or a component."""

    section: int | None = None
    component: str | None = None

    def begins(self, text: str) -> bool:
        """Tell whether a record may begin a cycle of it."""
        if self.section is not None:
            return '"cycle.started"' in text and f'"section": {self.section},' in text
        return '"task.started"' in text and self._named in text

    def concerns(self, texts: Iterable[str]) -> Callable[[str], bool]:
        """Return what tells of a record whether it may concern it, before it is read.

        :param texts: all the records: only the start of an attempt names its component
        """
        if self.section is not None:
            return lambda text: f'"section": {self.section},' in text
        tasks = {match[0] for text in texts if self.begins(text) and (match := _TASK.search(text))}
        return lambda text: self._named in text or any(task in text for task in tasks)

    @property
    def _named(self) -> str:
        return f'"component": "{self.component}"'


_TASK = re.compile(r'"task": "[^"]*"')


def history_of(
    look: Look, subject: Subject, now: float, described: CellDescription | None
) -> dict[str, Any]:
    """Return cycles, failures, times in states, and how long tasks took.

    :param now: up to when it is in its present state
    :param described: for nominal times; None: not known
    """
    fold = WorkFold(subject.section, subject.component)
    for event in reversed(_last_events(look, subject)):
        fold.follow(event)
    fold.until(now)
    return {
        'cycles': [_cycle(cycle) for cycle in reversed(fold.cycles)],
        'failures': [
            {**failure._asdict(), 'said': said_in_each(failure.message)}
            for failure in reversed(fold.failures)
        ],
        'running': [attempt._asdict() for attempt in fold.in_flight()],
        'time_in': {state: round(seconds, 3) for state, seconds in fold.time_in.items()},
        'tasks': _tasks(fold, described),
        'damage': look.damage,
        'has_beginning': len(fold.cycles) == MOST_CYCLES,
    }


def _last_events(look: Look, subject: Subject) -> list[Event]:
    """Return what concerns it since the last cycles began, newest first."""
    records: list[Record] = []
    begun = 0
    wanted = Wanted(events=FOLLOWED, newest_first=True)
    for record in islice(each(look, wanted), MOST_RECORDS):
        records.append(record)
        begun += subject.begins(record.text)
        if begun > MOST_CYCLES:
            break
    may_concern = subject.concerns(record.text for record in records)
    last_events = (
        event_of(record)
        for record in records
        if may_concern(record.text) or f'"{ClockStepped.event}"' in record.text
    )
    return [event for event in last_events if event is not None]


def _cycle(cycle: Cycle) -> dict[str, Any]:
    return {**vars(cycle), 'tasks': [task._asdict() for task in cycle.tasks]}


def _tasks(fold: WorkFold, described: CellDescription | None) -> dict[str, Any]:
    return {
        f'{component}.{name}' if fold.section is not None else name: {
            'nominal_s': _nominal_s(described, component, name),
            'lately_s': round(median(times), 3),
            'times_s': [round(time, 3) for time in times],
        }
        for (component, name), times in fold.times.items()
    }


def _nominal_s(described: CellDescription | None, component: str, task: str) -> float | None:
    components = described.components if described is not None else ()
    candidates = (candidate for candidate in components if candidate.name == component)
    return next(
        (
            candidate.durations_s.get(task, candidate.default_duration_s)
            for candidate in candidates
        ),
        None,
    )


# The record of one item.

_IDENTIFIED = (e.ItemIdentified.event,)


def item_record(look: Look, item: str) -> dict[str, Any] | None:
    """Return everything about an item; None: nothing is known of it."""
    history = item_history(reading(look), item)
    if history is None:
        return None
    begun, plain = history.started is not None, plain_item(history)
    for task in plain['tasks']:
        task['said'] = said_in_each(task['message'])
    return {**plain, 'damage': look.damage, 'has_beginning': begun}


def reading(look: Look) -> Reading:
    """Return what reads the records; damage is noted in the look."""
    return Reading(look.records, look.damage.append)


def items_of(look: Look, serial: str) -> dict[str, Any]:
    """Return the items of a serial, the newest first."""
    wanted, serial = Wanted(events=_IDENTIFIED, newest_first=True), serial.strip()
    name = json.dumps(serial, ensure_ascii=False)
    items = [
        {'item': event.item, 'job': event.job, 'time': event.time}
        for event in events(look, wanted, lambda text: name in text or '\\' in text)
        if isinstance(event, e.ItemIdentified) and event.serial == serial
    ]
    return {'items': items, 'damage': look.damage, 'has_beginning': False}
