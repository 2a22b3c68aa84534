"""Queries of a journal and their results: pages, each with a cursor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from typing import NamedTuple

from bt_orchestrator.model.jobs.job_record import JobRecord


@dataclass(frozen=True)
class Wanted:
    """A selection of event records, and where it begins."""

    after_seq: int = 0
    job: str | None = None
    events: tuple[str, ...] = ()
    """Event names, with `*` as wildcard; a name that ends with a dot is a prefix; empty: all."""
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
        """Tell whether it selects such a record, regardless of its number."""
        return (
            self.job in (None, job)
            and (self.since is None or time >= self.since)
            and (self.until is None or time <= self.until)
            and (not self.events or any(fnmatchcase(event, pattern) for pattern in self.patterns))
        )

    def past(self, seq: int) -> Wanted:
        """Return the rest of the selection after an event."""
        if self.newest_first:
            return replace(self, before_seq=seq)
        return replace(self, after_seq=max(self.after_seq, seq))


class Extent(NamedTuple):
    """How far a journal reaches."""

    history: str
    """Event numbers are valid only within one; empty: not known."""
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
    """Number of lost records; 0: none, as far as is known."""


@dataclass(frozen=True)
class RecordPage:
    """Some of the wanted records, of one moment of the journal."""

    history: str
    """History of the records. If it changes: restart from the beginning."""
    first_seq: int
    """Events before this one were removed by retention."""
    records: Sequence[Record]
    damage: Sequence[Damage]
    """Damage found between these records, for any job; the same may be reported again."""
    rest: Wanted
    """The cursor: what to request next, now or when there is more."""
    is_last: bool
    """There are no further wanted records at this moment."""


class JobPlace(NamedTuple):
    """The place of a job among the others: the cursor of summaries."""

    queued: float
    job: str


@dataclass(frozen=True)
class Summaries:
    """Summaries of some of the jobs that ended."""

    jobs: Sequence[JobRecord]
    damage: Sequence[Damage]
    rest: JobPlace | None
    """The place to continue at; None: this is the end."""
