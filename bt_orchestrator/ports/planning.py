"""Questions about what was, and about what would be; forecasts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple, Protocol

from bt_orchestrator.model.requests import Asked
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.ports.door import Moment


class Past(Protocol):
    """Any past state of a cell, from its journal."""

    def status_at(self, seq: int, at: float | None = None) -> CellStatus:
        """Return the status of the cell after an event, with the reasons why it waited.

        :param at: a moment before the next event; None: the moment of the event
        :raises NotKept: that event, or what came before it, is not in the journal
        """


class ExpectedJob(NamedTuple):
    """When a job is expected to end."""

    job: str
    ends_s: float | None
    """Seconds from the given moment; None: it does not end in the present situation."""


SAME_S = 1.0
"""Ends that differ by less are the same: both runs begin with the same moment."""


class JobChange(NamedTuple):
    """A job without and with some requests."""

    job: str
    before: ExpectedJob | None
    """None: it is there only with the requests."""
    after: ExpectedJob | None
    """None: the requests take it away."""
    due_s: float | None = None
    """When it should end, in seconds from the given moment; None: its order does not say."""

    @property
    def change(self) -> str:
        """Return what becomes of its end, in one word.

        `new`, `gone`: the job is there only with the requests, or only without; `never`, `open`,
        `known`: its end is known in neither case, only without or only with them; `same`,
        `earlier`, `later`.
        """
        if self.before is None or self.after is None:
            return 'gone' if self.after is None else 'new'
        if self.by_s is None:
            is_as_before = self.before.ends_s == self.after.ends_s
            return 'never' if is_as_before else 'open' if self.after.ends_s is None else 'known'
        if abs(self.by_s) < SAME_S:
            return 'same'
        return 'later' if self.by_s > 0 else 'earlier'

    @property
    def by_s(self) -> float | None:
        """Return how much later it ends; None: one of both ends is not known."""
        before, after = (end and end.ends_s for end in (self.before, self.after))
        return None if before is None or after is None else after - before

    def is_late(self, job: ExpectedJob | None) -> bool:
        """Tell whether it ends after its due time, before or after."""
        ends_s = job and job.ends_s
        return ends_s is not None and self.due_s is not None and ends_s > self.due_s


class Consequence(NamedTuple):
    """The effects of some requests."""

    before: Sequence[ExpectedJob]
    after: Sequence[ExpectedJob]
    refusals: Sequence[str]
    """Messages of the requests that would be refused, in order; empty: none."""
    unknown: Mapping[str, str] = {}
    """Why a job has no end after them, by its id."""
    notes: Sequence[str] = ()
    """Facts that the node will check in earnest, and that could not be checked here, in sentences.
    """
    due_s: Mapping[str, float] = {}
    """When jobs should end, by their ids, in seconds from the given moment."""

    @property
    def changes(self) -> Iterator[JobChange]:
        """Yield every job without and with the requests, in the order of then."""
        before, after = ({end.job: end for end in jobs} for jobs in (self.before, self.after))
        for job in {**after, **before}:
            yield JobChange(job, before.get(job), after.get(job), self.due_s.get(job))


class ProposedJob(NamedTuple):
    """A job as things are, and in an order that is proposed."""

    job: str
    place: int
    """In the queue of now, from 1; 0: it is on the line."""
    new_place: int
    priority: int
    due: float | None
    """When it should have ended, seconds since the epoch; None: not said."""
    ends_s: float | None
    """Seconds from the given moment, as things are; None: not known."""
    new_ends_s: float | None
    stays: str = ''
    """Why it keeps its place; empty: it need not."""


class Proposal(NamedTuple):
    """An order for the queue (semantics 6.7)."""

    jobs: Sequence[ProposedJob]
    """Those on the line, then the queue in the order that is proposed."""
    queue_digest: str
    """Of the queue that it is for."""
    late_s: float
    """Seconds that all jobs together end too late, as things are."""
    new_late_s: float
    looked_at: int
    """So many orders were run."""
    orders: int
    """So many keep priorities and places that stay."""
    is_best: bool
    """No order of these is better; False: of those that were looked at."""
    unknown: Mapping[str, str] = {}
    """Why a job has no end in the order that is proposed, by its id."""
    changeover_s: float = 0.0
    """Seconds of all changes of setups between jobs (semantics 5.3), as things are."""
    new_changeover_s: float = 0.0

    @property
    def order(self) -> Sequence[str]:
        """The queue in the order that is proposed."""
        return [job.job for job in self.jobs if job.place]

    @property
    def is_new(self) -> bool:
        """Whether it differs from the present order."""
        return any(job.place != job.new_place for job in self.jobs)


class WrongField(NamedTuple):
    """A mistake in one key of a work order."""

    field: str
    """For instance params.lot; empty: of the order as a whole."""
    what: str
    hint: str


class CheckedOrder(NamedTuple):
    """The answer that a work order would get."""

    accepted: bool
    message: str
    """Why it would be refused, or not be checked; empty: it would be accepted."""
    wrong: Sequence[WrongField] = ()
    is_checked: bool = True
    """False: its script is not known here; the node may know it."""


class WhatIf(Protocol):
    """Predicts the effect of requests on jobs, with the engine that runs the cell."""

    def ask(self, requests: Sequence[Asked]) -> Consequence:
        """Predict when jobs end without and with these requests.

        :raises NotKept: the state to start from is not available
        """

    def propose(self) -> Proposal:
        """Propose an order of the queue.

        :raises NotKept: the state to start from is not available
        """

    def check(self, order: Mapping[str, object]) -> CheckedOrder:
        """Tell whether an order, with the keys of an order file, would be queued.

        :raises NotKept: the state to start from is not available
        """


class Planning(Protocol):
    """Answers a planner's questions outside the asking process. One thread at a time."""

    def what_if(self, moment: Moment, requests: Sequence[Asked]) -> Consequence:
        """Predict when jobs end from a moment on, without and with these requests.

        :raises NotKept: nothing could be worked out
        """

    def propose(self, moment: Moment) -> Proposal:
        """Propose an order for the queue of a moment.

        :raises NotKept: nothing could be worked out
        """

    def check(self, moment: Moment, order: Mapping[str, object]) -> CheckedOrder:
        """Tell whether an order, with the keys of an order file, would be queued.

        :raises NotKept: nothing could be worked out
        """

    def close(self) -> None:
        """Stop working; may be called from any thread."""


# Forecasts of the cell that runs.


class Foresight(Protocol):
    """Forecasts when jobs end, outside the tick thread."""

    def ask(self, state: str, observed_s: Mapping[str, Mapping[str, float]], now_s: float) -> None:
        """Request a forecast from a state; returns at once. A later request replaces it.

        :param state: of `model.keeping.snapshot`, as JSON
        :param observed_s: task durations in seconds, by component and task constant
        """

    @property
    def ends_s(self) -> Mapping[str, float]:
        """When each live job will end, by the last forecast; unknown ones are left out."""

    @property
    def took_s(self) -> float:
        """How many seconds the last forecast took; 0: there was none."""

    def close(self) -> None:
        """Stop working."""
