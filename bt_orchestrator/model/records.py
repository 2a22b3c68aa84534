"""What a reader asks a journal for, and what it gets: pages, each with a cursor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from typing import NamedTuple

from bt_orchestrator.model.jobs.job_record import JobRecord


@dataclass(frozen=True)
class Wanted:
    """Which records of events somebody wants, and from where on."""

    after_seq: int = 0
    job: str | None = None
    events: tuple[str, ...] = ()
    """Names, with `*` for anything; one that ends with a dot stands for all that begin so; empty:
    all."""
    since: float | None = None
    """Seconds since the epoch, this moment included."""
    until: float | None = None
    before_seq: int | None = None
    newest_first: bool = False

    @property
    def patterns(self) -> tuple[str, ...]:
        """Names of events as file names are matched."""
        return tuple(f'{name}*' if name.endswith('.') else name for name in self.events)

    def takes(self, event: str, job: str | None, time: float) -> bool:
        """Tell whether it is about such a record, whatever its number is."""
        return (
            self.job in (None, job)
            and (self.since is None or time >= self.since)
            and (self.until is None or time <= self.until)
            and (not self.events or any(fnmatchcase(event, one) for one in self.patterns))
        )

    def past(self, seq: int) -> Wanted:
        """Return what is still wanted once everything up to an event has been looked at."""
        if self.newest_first:
            return replace(self, before_seq=seq)
        return replace(self, after_seq=max(self.after_seq, seq))


class Extent(NamedTuple):
    """How far a journal reaches."""

    history: str
    """Numbers of events say something only within one; empty: not known."""
    first_seq: int
    """Of the first event that retention has left, or that is to come."""
    last_seq: int
    """0: there is none."""


class Record(NamedTuple):
    """The record of one event (formats: events)."""

    seq: int
    text: str
    """JSON, as it was written."""


class Damage(NamedTuple):
    """Something that cannot be shown."""

    what: str
    """A sentence for a person."""
    number: int = 1
    """So many records are lost by it; 0: none, as far as is known."""


@dataclass(frozen=True)
class Page:
    """Some of the records that are wanted, of one moment of the journal."""

    history: str
    """Of which they are. Another one than before: begin anew."""
    first_seq: int
    """Events before this one were removed by right."""
    records: Sequence[Record]
    damage: Sequence[Damage]
    """What was met between these records, whoever it was about; the same may be told again."""
    rest: Wanted
    """The cursor: what to ask for next, now or when there is more."""
    is_last: bool
    """Nothing that is wanted is there behind it at this moment."""


class JobPlace(NamedTuple):
    """The place of a job among the others: the cursor of summaries."""

    queued: float
    job: str


@dataclass(frozen=True)
class Summaries:
    """Some of the jobs that ended, as far as they are known without their events."""

    jobs: Sequence[JobRecord]
    damage: Sequence[Damage]
    rest: JobPlace | None
    """After which to go on; None: there are no more."""
