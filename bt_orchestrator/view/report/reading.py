"""Reading a journal page by page, to its end, with each damage reported once."""

from __future__ import annotations

import json
import logging
import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

from bt_orchestrator.base.errors import DatabaseAway
from bt_orchestrator.model.codec import known_event
from bt_orchestrator.model.events import Event, ScriptLoaded
from bt_orchestrator.model.jobs.job_record import JobRecord
from bt_orchestrator.model.keeping.records import Damage, Record, RecordPage, Wanted
from bt_orchestrator.model.script import Script
from bt_orchestrator.ports import Records
from bt_orchestrator.view.report.account.steady_time import SteadyTime
from bt_orchestrator.view.report.ended_jobs import FOLLOWED, JobFold
from bt_orchestrator.view.report.line_stops import GivenReasons

log = logging.getLogger(__name__)

AGAIN_S = 1.0
"""Time between two attempts to reach a database that is away."""

MOST = 1000
"""Records that are asked for at a time."""


def removed(first: int, last: int) -> str:
    """Return the message that events are no longer available."""
    return f'events {first} to {last} are not in the journal any more'


class Reading:
    """Reads a journal of any kind of store."""

    def __init__(self, records: Records, tell: Callable[[str], None] = log.warning) -> None:
        """Begin.

        :param tell: called with a sentence for everything that cannot be shown
        """
        self.records = records
        self.steady: SteadyTime | None = None
        """The known steps of the clock; None: not asked for yet."""
        self.reasons: GivenReasons | None = None
        """The known reasons of stops; None: not asked for yet."""
        self.lost = 0
        """Records that are damaged or missing, as far as was looked."""
        self._tell = tell
        self._told: set[str] = set()

    def page(self, wanted: Wanted, most: int = MOST) -> RecordPage:
        """Return the next page, with its damage told."""
        page = self.records.page(wanted, most)
        self.tell_new(page.damage)
        return page

    def pages(
        self,
        wanted: Wanted,
        *,
        is_continued: bool = False,
        ends_within: Callable[[float], bool] | None = None,
    ) -> Iterator[RecordPage]:
        """Yield page after page, oldest first, without end: the last one again as it grows.

        It reports events that were removed before they were read, and a change to another history,
        which is then read from its beginning.

        :param is_continued: earlier events were read before
        :param ends_within: waits so many seconds for an end that a person wants, and tells whether
            it came: a database that is away is waited for; None: it is not
        """
        begin, history = replace(wanted, after_seq=0), None
        while True:
            page = self.page(wanted) if ends_within is None else self._patient(wanted, ends_within)
            if page is None:
                return
            if history is not None and page.history != history:
                self._tell(f'the journal goes on as history {page.history}; from its beginning:')
                wanted, is_continued = begin, False
            else:
                if is_continued and page.first_seq > wanted.after_seq + 1:
                    self._tell(removed(wanted.after_seq + 1, page.first_seq - 1))
                yield page
                wanted, is_continued = page.rest, True
            history = page.history

    def _patient(self, wanted: Wanted, ends_within: Callable[[float], bool]) -> RecordPage | None:
        """Return the next page, once there is a database; None: a person wants an end."""
        is_known = False
        while True:
            try:
                return self.page(wanted)
            except DatabaseAway as error:
                if not is_known:
                    self._tell(f'{error}; goes on when the database is back, Ctrl-C ends')
                is_known = True
            if ends_within(AGAIN_S):
                return None

    def known(self, page: RecordPage) -> Iterator[Event]:
        """Yield the events of a page that this program knows."""
        for record in page.records:
            event = known_event(json.loads(record.text))
            if event is not None:
                yield event

    def each(self, wanted: Wanted, most: float = math.inf) -> Iterator[Record]:
        """Yield the records that are wanted and there at this moment, so many at most."""
        is_last = False
        while most > 0 and not is_last:
            page = self.page(wanted, int(min(most, MOST)))
            yield from page.records
            wanted, is_last = page.rest, page.is_last
            most -= len(page.records)

    def events(
        self, wanted: Wanted, may_be: Callable[[str], bool] = lambda _: True
    ) -> Iterator[Event]:
        """Yield the wanted events that this program knows.

        :param may_be: looks at the text of a record, before it is read
        """
        for record in self.each(wanted):
            event = known_event(json.loads(record.text)) if may_be(record.text) else None
            if event is not None:
                yield event

    def first(self, wanted: Wanted) -> Event | None:
        """Return the first wanted event; None: there is none."""
        record = next(self.each(wanted, 1), None)
        return None if record is None else known_event(json.loads(record.text))

    def summaries(self) -> Iterator[JobRecord]:
        """Yield what is kept of jobs that ended, as they were queued."""
        after, is_first = None, True
        while is_first or after is not None:
            page = self.records.summaries(after)
            self.tell_new(page.damage)
            yield from page.jobs
            after, is_first = page.rest, False

    def jobs(self, job: str | None = None) -> JobFold:
        """Return the records of jobs and their items.

        :param job: this one alone; None: all of them
        """
        fold = JobFold(self.summaries())
        for event in self.events(Wanted(job=job, events=FOLLOWED)):
            fold.follow(event)
        return fold

    def script(self, digest: str) -> Script | None:
        """Return a script by its digest; None: its event is not there, or not to be read."""
        for event in self.events(Wanted(events=(ScriptLoaded.event,))):
            if isinstance(event, ScriptLoaded) and event.digest == digest:
                return event.definition
        return None

    def tell_new(self, damage: Iterable[Damage]) -> None:
        """Tell what cannot be shown, each once."""
        for loss in damage:
            if loss.what not in self._told:
                self._told.add(loss.what)
                self.lost += loss.number
                self._tell(loss.what)
