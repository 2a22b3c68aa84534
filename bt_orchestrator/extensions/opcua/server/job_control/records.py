"""Data that is pulled, because it is long: the items of a job, and events of the cell."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from contextlib import closing
from typing import Any, NamedTuple

from asyncua import ua

from bt_orchestrator.base.errors import JournalUnusable, NodeUnreachable
from bt_orchestrator.extensions.opcua.server.bridge import Bridge
from bt_orchestrator.extensions.opcua.server.calls import Argument
from bt_orchestrator.extensions.opcua.server.space import Space
from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import json_of, to_plain, to_text
from bt_orchestrator.model.jobs.job_record import ItemRecord, JobRecord
from bt_orchestrator.model.limits import EVENTS_BYTES, fitting
from bt_orchestrator.view.report.ended_jobs import JobFold
from bt_orchestrator.view.report.reading import Reading

TEXT, NUMBER, LONG = ua.VariantType.String, ua.VariantType.UInt32, ua.VariantType.UInt64
YES_NO = ua.VariantType.Boolean

MOST_ITEMS = 500
ITEMS = 100
"""In one answer: at most, and unless the client says how many."""

LOOK_BACK = 20_000
"""Events that are looked through for a job, where the server reads no journal."""


class Found(NamedTuple):
    """A job with its items."""

    job: JobRecord | None
    is_whole: bool
    """Its beginning was found, too."""


class Records:
    """Our own methods GetItems and GetEvents."""

    def __init__(self, bridge: Bridge) -> None:
        self._bridge = bridge

    async def build(self, space: Space, results: str) -> None:
        """Make the methods.

        :param results: path of the job response provider
        """
        await space.method(
            f'{results}/GetItems',
            self._items,
            [
                Argument('JobOrderID', TEXT, 'id of the job'),
                Argument('After', TEXT, 'item before the first to return; empty: from the first'),
                Argument('Most', NUMBER, f'items in the answer; 0: {ITEMS}; at most {MOST_ITEMS}'),
            ],
            [
                Argument('Items', TEXT, 'JSON of an item each, with its results', is_list=True),
                Argument('IsLast', YES_NO, 'there are no more items yet'),
                Argument('IsWhole', YES_NO, 'false: what was before is not known to this server'),
            ],
            'the items of a job, oldest first: how each ended, when, and the results of its tasks',
        )
        await space.method(
            'GetEvents',
            self._events,
            [
                Argument(
                    'AfterSeq', LONG, 'NextSeq of the answer before; 0: from the first event'
                ),
                Argument('Most', NUMBER, 'events in the answer; 0: as many as fit'),
                Argument(
                    'History',
                    TEXT,
                    'History of the answer before; empty: there was none. With '
                    'that of another journal the answer begins with the first event',
                    is_optional=True,
                ),
            ],
            [
                Argument('Events', TEXT, 'JSON of an event each', is_list=True),
                Argument(
                    'LastSeq',
                    LONG,
                    'number of the newest event of the journal. The answer may '
                    'end before it: go on with NextSeq',
                ),
                Argument('History', TEXT, 'name of the journal; if it changes, numbers restart'),
                Argument('NextSeq', LONG, 'AfterSeq of the next call'),
                Argument('IsLast', YES_NO, 'there are no more events yet'),
            ],
            'events from the journal of the cell, oldest first; the first one may have a higher '
            'number than asked for, if earlier ones were removed',
        )

    async def _items(self, job: str, after: str, most: int) -> Sequence[ua.Variant]:
        record = await self._found(job)
        if record.job is None:
            raise ua.UaStatusCodeError(ua.StatusCodes.BadNotFound)
        items = list(record.job.items.values())
        names = [item.item for item in items]
        if after and after not in names:
            raise ua.UaStatusCodeError(ua.StatusCodes.BadInvalidArgument)
        first = names.index(after) + 1 if after else 0
        wanted = items[first : first + min(most or ITEMS, MOST_ITEMS)]
        texts = list(fitting(map(json_of, map(item_plain, wanted)), EVENTS_BYTES, len))
        return [
            ua.Variant(texts, TEXT, is_array=True),
            ua.Variant(first + len(texts) >= len(items), YES_NO),
            ua.Variant(record.is_whole, YES_NO),
        ]

    async def _events(
        self, after: int, most: int, history: str | None = None
    ) -> Sequence[ua.Variant]:
        doors = self._bridge.doors
        try:
            page = await doors.events_after(after, most)
            if history and page.history != history:
                page = await doors.events_after(0, most)
        except NodeUnreachable as error:
            raise ua.UaStatusCodeError(ua.StatusCodes.BadNoCommunication) from error
        answer = [
            ua.Variant([to_text(event) for event in page.events], TEXT, is_array=True),
            ua.Variant(page.last_seq, LONG),
            ua.Variant(page.history, TEXT),
        ]
        if history is None:  # a client of before, which may expect so many outputs
            return answer
        after = page.events[-1].seq if page.events else min(after, page.last_seq)
        is_last = not page.events or after >= page.last_seq
        return [*answer, ua.Variant(after, LONG), ua.Variant(is_last, YES_NO)]

    async def _found(self, job: str) -> Found:
        try:
            if self._bridge.sources.open_records is not None:
                return await asyncio.to_thread(self._in_journal, job)
            return await self._at_the_door(job)
        except NodeUnreachable as error:
            raise ua.UaStatusCodeError(ua.StatusCodes.BadNoCommunication) from error
        except JournalUnusable as error:
            raise ua.UaStatusCodeError(ua.StatusCodes.BadResourceUnavailable) from error

    def _in_journal(self, job: str) -> Found:
        opened = self._bridge.sources.open_records
        assert opened is not None
        with closing(opened()) as records:
            record = Reading(records).jobs(job).jobs.get(job)
        return Found(record, record is not None and record.complete)

    async def _at_the_door(self, job: str) -> Found:
        """Look through the last events of the cell."""
        doors, fold = self._bridge.doors, JobFold()
        seq = max(0, self._bridge.newest - LOOK_BACK)
        while True:
            page = await doors.events_after(seq)
            for event in page.events:
                if getattr(event, 'job', None) != job:
                    continue
                fold.follow(event)
                if isinstance(event, _ENDS):
                    return Found(fold.jobs.get(job), True)
            if not page.events or page.events[-1].seq >= page.last_seq:
                return Found(fold.jobs.get(job), True)
            seq = page.events[-1].seq


def item_plain(item: ItemRecord) -> dict[str, Any]:
    """Return the facts of an item in the form of JSON."""
    plain: dict[str, Any] = to_plain(item, whole=True)
    if not item.clock_set_s:
        del plain['clock_set_s']
    return plain


_ENDS = (e.JobCompleted, e.JobAborted, e.JobRemoved)
