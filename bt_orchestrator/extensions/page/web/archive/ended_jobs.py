"""Jobs by pages, newest first, and one job with its items.

A job that ended has a summary in the journal. One that has none yet, because it goes on or has
just ended, is folded from its events.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from bt_orchestrator.extensions.page.web.archive.archive import (
    Look,
    event_of,
    events,
    events_of_job,
)
from bt_orchestrator.extensions.page.web.wording import said_in_each
from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import plain_but, to_plain
from bt_orchestrator.model.jobs.job_record import ItemRecord, JobRecord, all_counts
from bt_orchestrator.model.keeping.records import JobPlace, Wanted
from bt_orchestrator.view.report.ended_jobs import FOLLOWED, JobFold

MOST = 50
"""Most jobs of one answer."""

MOST_ITEMS = 2000
"""Most items of one answer; the last ones are shown."""

_QUEUED = (e.JobQueued.event,)
_OF_A_JOB = (e.JobStarted, e.JobCompleted, e.JobAborted)

EVENTS, SUMMARIES = 'e', 's'
"""First letters of cursors: among the events, or among the summaries of jobs without events."""


def jobs_page(look: Look, cursor: str, most: int) -> dict[str, Any]:
    """Return summaries of jobs, newest first, and the cursor to go on with.

    :param cursor: as an answer named it; empty: from the newest
    :raises ValueError: it is none
    """
    most = max(1, min(most, MOST))
    jobs: list[dict[str, Any]] = []
    rest: str | None = cursor or EVENTS
    if cursor and not cursor.startswith((EVENTS, SUMMARIES)):
        raise ValueError(f'no place among jobs is {cursor!r}')
    if rest is not None and rest.startswith(EVENTS):
        records, rest = _with_events(look, rest, most)
        jobs += [summary(record, is_whole=True) for record in records]
    if rest is not None and rest.startswith(SUMMARIES) and len(jobs) < most:
        records, rest = _without_events(look, rest, most - len(jobs))
        jobs += [summary(record, is_whole=False) for record in records]
    return {'jobs': jobs, 'rest': rest, 'damage': look.damage}


def job_with_items(look: Look, job: str) -> dict[str, Any] | None:
    """Return a job with its items and failures; None: nothing is known of it."""
    record = job_record(look, job)
    if record is None:
        return None
    items = list(record.items.values())
    return {
        'job': {**summary(record, is_whole=record.complete), 'seconds': record.seconds},
        'items': list(map(_item, items[-MOST_ITEMS:])),
        'left_out': max(0, len(items) - MOST_ITEMS),
        'failures': [
            {**plain_but(failure), 'said': said_in_each(failure.message)}
            for failure in record.failures
        ],
        'has_beginning': record.complete,
        'is_whole': record.complete and not look.damage,
        'why_not': '; '.join(
            [*([] if record.complete else ['its events are not kept any more']), *look.damage]
        ),
    }


def job_record(look: Look, job: str) -> JobRecord | None:
    """Return the record of a job, from its events or else its summary; None: it is not known."""
    fold, seqs = JobFold(), dict[str, tuple[int, int]]()
    for event in events_of_job(look, job, FOLLOWED):
        fold.follow(event)
        subject = job if isinstance(event, _OF_A_JOB) else getattr(event, 'item', None)
        if subject is not None:
            begun, _ = seqs.setdefault(subject, (event.seq, event.seq))
            if isinstance(event, (e.ItemRemoved, e.ItemMissing, *_OF_A_JOB)):
                seqs[subject] = begun, event.seq
    record = fold.jobs.get(job)
    if record is None:
        return next(_summaries_of(look, {job}), None)
    _note_steps(look, record, seqs)
    return record


def _note_steps(look: Look, record: JobRecord, seqs: Mapping[str, tuple[int, int]]) -> None:
    """Note at the job and at each item by how much the clock was set while it was there.

    :param seqs: numbers of the first event of each item, and of that with which it left; of the
        job, from its start to its end
    """
    if not seqs:
        return
    first = min(first for first, _ in seqs.values())
    last = max(last for _, last in seqs.values())
    wanted = Wanted(after_seq=first, before_seq=last, events=(e.ClockStepped.event,))
    steps = [event for event in events(look, wanted) if isinstance(event, e.ClockStepped)]
    if not steps:
        return
    subjects: dict[str, JobRecord | ItemRecord] = {record.job: record, **record.items}
    for name, subject in subjects.items():
        begun, ended = seqs.get(name, (0, 0))
        subject.clock_set_s = sum(step.seconds for step in steps if begun < step.seq < ended)


def summary(record: JobRecord, *, is_whole: bool) -> dict[str, Any]:
    """Return what is said of a job in a list.

    :param is_whole: its events are on record, and so are its items
    """
    return {
        'id': record.job,
        'script': record.script,
        'recipe': record.recipe,
        'recipe_version': record.recipe_version,
        'rest_of': record.rest_of,
        'status': record.status,
        'reason': record.reason,
        'quantity': record.quantity,
        'queued': record.queued,
        'started': record.started,
        'ended': record.ended,
        'counts': all_counts(record.counts),
        'params': to_plain(record.params),
        'terms': to_plain(record.terms, whole=True),
        'is_whole': is_whole,
    }


def _item(item: ItemRecord) -> dict[str, Any]:
    return {
        'id': item.item,
        'how': item.how,
        'good': item.good,
        'started': item.started,
        'ended': item.ended,
        'seconds': item.seconds,
        'nonconforming': list(item.nonconforming),
        'rounds': dict(item.rounds),
        'serial': item.serial,
        'lots': dict(item.lots),
        'results': to_plain(item.results),
    }


# --- jobs whose events are there ----------------------------------------------------------------


def _with_events(look: Look, cursor: str, most: int) -> tuple[list[JobRecord], str | None]:
    """Return jobs whose beginning is on record, newest first."""
    wanted = Wanted(events=_QUEUED, newest_first=True, before_seq=_number(cursor))
    page = look.records.page(wanted, most)
    look.note(list(page.damage))
    queued = {
        event.job: event for event in map(event_of, page.records) if isinstance(event, e.JobQueued)
    }
    since = min((event.time for event in queued.values()), default=0.0)
    known = {record.job: record for record in _summaries_of(look, queued, since)}
    known |= _folded(
        look, {name: event.seq for name, event in queued.items() if name not in known}
    )
    records = [known[name] for name in queued if name in known]
    if not page.is_last:
        return records, f'{EVENTS}{page.rest.before_seq}'
    oldest = min(queued.values(), key=lambda event: event.seq, default=None)
    return records, f'{SUMMARIES}{oldest.time if oldest else ""}:{oldest.job if oldest else ""}'


def _folded(look: Look, beginnings: Mapping[str, int]) -> dict[str, JobRecord]:
    """Return records of jobs from their events.

    :param beginnings: number of the first event of each
    """
    if not beginnings:
        return {}
    fold = JobFold()
    is_theirs = _names(beginnings)
    wanted = Wanted(after_seq=min(beginnings.values()) - 1, events=FOLLOWED)
    for event in events(look, wanted, is_theirs):
        if getattr(event, 'job', None) in beginnings:
            fold.follow(event)
    return fold.jobs


def _names(jobs: Iterable[str]) -> Any:
    """Return what tells whether a text may name one of some jobs."""
    pattern = re.compile('|'.join(map(re.escape, jobs)))
    return lambda text: '\\' in text or pattern.search(text) is not None


def _number(cursor: str) -> int | None:
    text = cursor.removeprefix(EVENTS)
    return int(text) if text else None


# --- jobs of which a summary is left ------------------------------------------------------------


def _without_events(look: Look, cursor: str, most: int) -> tuple[list[JobRecord], str | None]:
    """Return jobs with only a summary left, newest first."""
    time, _, job = cursor.removeprefix(SUMMARIES).partition(':')
    after = JobPlace(float(time), job) if time else None
    page = look.records.summaries(after, most, newest_first=True)
    look.note(list(page.damage))
    rest = page.rest
    return list(page.jobs), None if rest is None else f'{SUMMARIES}{rest.queued!r}:{rest.job}'


def _summaries_of(
    look: Look, names: Iterable[str], since: float = -math.inf
) -> Iterator[JobRecord]:
    """Yield the summaries of some jobs, as far as there are any.

    :param since: none of them was queued earlier
    """
    left = set(names)
    after: JobPlace | None = None
    while left:
        page = look.records.summaries(after, 200, newest_first=True)
        look.note(list(page.damage))
        for record in page.jobs:
            if record.queued < since:
                return
            if record.job in left:
                left.discard(record.job)
                yield record
        after = page.rest
        if after is None:
            return
