"""Where the past is read from: a journal file, or what the door tells; scans of it."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import dataclass, field
from typing import TypeVar

from bt_orchestrator.extensions.page.web.archive.heard import Heard
from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import known_event
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.keeping.records import Damage, Extent, Record, Wanted
from bt_orchestrator.ports import Records

_T = TypeVar('_T')

OpenRecords = Callable[[], Records]
"""Opens a journal to be read in the thread that calls it.

:raises JournalUnusable: it cannot be read
"""


@dataclass
class Look:
    """One reading: its records, and what was found damaged on the way."""

    records: Records
    extent: Extent
    damage: list[str] = field(default_factory=list)

    def note(self, damage: tuple[Damage, ...] | list[Damage]) -> None:
        """Keep what cannot be shown, each once."""
        self.damage += [loss.what for loss in damage if loss.what not in self.damage]


class Archive:
    """Reads in a thread of its own: the server's loop never waits for a disk."""

    def __init__(
        self,
        heard: Heard,
        open_records: OpenRecords | None = None,
        history: Callable[[], str] = lambda: '',
    ) -> None:
        """Prepare.

        :param open_records: None: there is no journal file, and the door tells the last events
        :param history: tells the history of the node; empty: not known
        """
        self._heard = heard
        self._history = history
        self._open = open_records
        self._thread = ThreadPoolExecutor(1, 'page: reading')

    async def read(self, question: Callable[[Look], _T]) -> _T:
        """Return what a question comes to; it is called in the thread that reads.

        :raises JournalUnusable: the journal cannot be read
        """
        opened = self._open or _opens(await self._heard.records())
        loop = asyncio.get_running_loop()
        return await loop.run_in_executor(self._thread, _asked, opened, question)

    def why_not_whole(self, extent: Extent, *, has_beginning: bool = False) -> str:
        """Say what of the past is not known here; empty: everything is.

        :param has_beginning: what was asked for begins here, and needs nothing from before
        """
        node = self._history()
        if extent.history and node and extent.history != node:
            return (
                f'the journal of the page has the history {extent.history}, and the node has '
                f'{node}: give the page the journal that the node writes'
            )
        if extent.first_seq <= 1 or has_beginning:
            return ''
        if self._open is None:
            return (
                f'only events from {extent.first_seq} on are known here: the page reads no '
                'journal; whoever installed the page can give it the journal of the node'
            )
        return f'events before {extent.first_seq} are not in the journal any more'

    def close(self) -> None:
        """End the thread; a reading goes on to its end."""
        self._thread.shutdown(wait=False, cancel_futures=True)


def _opens(records: Records) -> OpenRecords:
    return lambda: records


def _asked(opened: OpenRecords, question: Callable[[Look], _T]) -> _T:
    with closing(opened()) as records:
        return question(Look(records, records.extent()))


# Scans of the records, with a limit: a long journal makes no reader wait.

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
    record = next(each(look, wanted, most=1), None)
    return 0 if record is None else record.seq - 1


def event_of(record: Record) -> Event | None:
    """Return the event of a record; None: this program does not know it."""
    return known_event(json.loads(record.text))
