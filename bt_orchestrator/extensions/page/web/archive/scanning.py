"""Scans of the records, with a limit: a long journal makes no reader wait."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence

from bt_orchestrator.extensions.page.web.archive.archive import Look
from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import known_event
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.records import Record, Wanted

PAGE = 1000


def each(look: Look, wanted: Wanted, most: int = PAGE) -> Iterator[Record]:
    """Yield the wanted records; what is damaged is noted.

    :param most: so many are read at a time
    """
    is_last = False
    while not is_last:
        page = look.records.page(wanted, most)
        look.note(list(page.damage))
        yield from page.records
        wanted, is_last = page.rest, page.is_last


def events(
    look: Look, wanted: Wanted, may_be: Callable[[str], bool] = lambda _: True
) -> Iterator[Event]:
    """Yield the wanted events that this program knows.

    :param may_be: looks at the text of a record, before it is read
    """
    for record in each(look, wanted):
        event = event_of(record) if may_be(record.text) else None
        if event is not None:
            yield event


def events_of_job(
    look: Look, job: str, kinds: Sequence[str], may_be: Callable[[str], bool] = lambda _: True
) -> Iterator[Event]:
    """Yield events of a job, from its beginning to its end: not the whole of a long journal.

    :param kinds: names as in `Wanted.events`
    """
    wanted = Wanted(after_seq=_before(look, job), job=job, events=(*kinds, *_ENDS))
    for event in events(
        look, wanted, lambda text: may_be(text) or any(end in text for end in _ENDS)
    ):
        yield event
        if event.event in _ENDS:
            return


_ENDS = (e.JobCompleted.event, e.JobAborted.event, e.JobRemoved.event)


def _before(look: Look, job: str) -> int:
    """Return the number before a job's first event; 0: that is not there."""
    wanted = Wanted(job=job, events=(e.JobQueued.event,), newest_first=True)
    found = next(each(look, wanted, most=1), None)
    return 0 if found is None else found.seq - 1


def event_of(record: Record) -> Event | None:
    """Return the event of a record; None: this program does not know it."""
    return known_event(json.loads(record.text))
