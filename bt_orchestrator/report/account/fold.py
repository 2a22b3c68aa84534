"""The fold from events to the account of a period: books every moment of planned time once."""

from __future__ import annotations

from collections import Counter
from copy import deepcopy
from dataclasses import dataclass

from bt_orchestrator.model import events as e
from bt_orchestrator.model.script import Script
from bt_orchestrator.report.account.losses import WORDS, Loss, Step
from bt_orchestrator.report.account.made import FOLLOWED as OF_ITEMS
from bt_orchestrator.report.account.made import Made, MadeFold
from bt_orchestrator.report.account.planned import Planned, us_of
from bt_orchestrator.report.account.standing import FOLLOWED as OF_STANDING
from bt_orchestrator.report.account.standing import Cause, Standing
from bt_orchestrator.report.account.stops import Held, Stop, StopBook
from bt_orchestrator.report.account.troubles import FailingTask, Repairs, TroubleBook

FOLLOWED = (
    *OF_STANDING,
    *OF_ITEMS,
    e.OperatorDecided.event,
    e.ScriptLoaded.event,
    e.ClockStepped.event,
)
"""Names of the events that an account needs."""

_NOT_RECORDED = Cause(Loss.NOT_RECORDED)


@dataclass(frozen=True)
class Times:
    """Where the time of a period went, as far as events alone can tell."""

    planned: Planned
    producing_us: int
    """Without rework."""
    lost_us: dict[Loss, int]
    """`rework` is as it was measured: time in which something was done again."""
    made: tuple[Made, ...]
    scripts: dict[str, Script]
    """Those that were made, by digest, as far as the journal has them."""
    stops: tuple[Stop, ...]
    holds: tuple[Held, ...]
    holds_left_out: int
    left_out_us: dict[Loss, int]
    failing: tuple[FailingTask, ...]
    repairs: tuple[Repairs, ...]
    cell: str
    """Name of the cell; empty: not known."""
    cells: tuple[str, ...]
    """Digests of the cell files that the node ran with in this time; empty: not known."""

    def step_us(self, *steps: Step) -> int:
        """Return the time lost in some steps."""
        return sum(us for loss, us in self.lost_us.items() if WORDS[loss].step in steps)

    @property
    def busy_us(self) -> int:
        """Planned busy time."""
        return self.planned.total_us - self.step_us(Step.NOT_BUSY)

    @property
    def production_us(self) -> int:
        """Actual production time: with rework."""
        return self.busy_us - self.step_us(Step.AVAILABILITY)


class AccountFold:
    """Takes in one event after another, oldest first."""

    def __init__(self, planned: Planned, *, is_whole: bool) -> None:
        """Begin.

        :param is_whole: the first event that comes is the first of all
        """
        self._planned = planned
        self._begin = planned.pieces[0][0] if planned.pieces else 0
        self._standing = Standing(is_whole=is_whole)
        self._now: int | None = None
        """Up to when the time is booked; it never goes back."""
        self._first: int | None = None
        self._lost: Counter[Loss] = Counter()
        self._producing = 0
        self._made = MadeFold()
        self._scripts: dict[str, Script] = {}
        self._stops = StopBook()
        self._troubles = TroubleBook()
        self._cell = ''
        self._cells: dict[str, None] = {}

    @property
    def cause(self) -> Cause | None:
        """What the time is lost to since the last event; None: the line produces."""
        return self._standing.cause()

    def follow(self, event: e.Event) -> None:
        """Take in the next event."""
        now = us_of(event.time)
        if self._now is None:
            self._now = min(self._begin, now)
            self._pass(now, _NOT_RECORDED)
        self._pass_until(event, now)
        self._take(event)

    def until(self, end: int) -> Times:
        """Return the account as far as a moment, from which no event has come yet.

        It may be asked at any time: the fold goes on from its last event. What a moment was lost
        to may come out later; a node that was killed says nothing before it starts again.
        """
        books = self._now, self._producing, self._lost, self._stops, self._troubles
        self._lost, self._stops, self._troubles = deepcopy(books[2:])
        try:
            return self._end(end)
        finally:
            self._now, self._producing, self._lost, self._stops, self._troubles = books

    def _end(self, end: int) -> Times:
        """Let the time pass up to the end, and return the account."""
        if self._now is None:
            self._now = self._begin
            self._pass(end, _NOT_RECORDED)
        self._pass(end, self._standing.cause())
        self._stops.end()
        made = self._made.made()
        used = {one.digest for one in made}
        return Times(
            self._planned.before(end),
            self._producing,
            {loss: us for loss in Loss if (us := self._lost[loss])},
            made,
            {digest: one for digest, one in self._scripts.items() if digest in used},
            self._stops.stops(),
            self._stops.holds(),
            self._stops.left_out_count,
            dict(self._stops.left_out),
            self._troubles.failing(),
            self._troubles.repairs(),
            self._cell,
            tuple(self._cells),
        )

    # --- time -------------------------------------------------------------------------------

    def _pass_until(self, event: e.Event, now: int) -> None:
        """Book the time since the last event."""
        cause = self._standing.cause()
        if isinstance(event, e.OrchestratorStarted) and self._standing.has_node:
            # A node that was killed says nothing; of the very first nothing was before.
            cause = self._standing.without_node() if cause != _NOT_RECORDED else cause
        elif isinstance(event, e.ClockStepped):
            # This event has the new time already; what really passed goes on from the old one.
            self._pass(now - us_of(event.seconds), cause)
            cause = _NOT_RECORDED
        self._pass(now, cause)

    def _pass(self, now: int, cause: Cause | None) -> None:
        """Book the time up to now; a clock that was set back makes nothing pass twice."""
        assert self._now is not None
        begin, self._now = self._now, max(self._now, now)
        us = self._planned.between(begin, self._now)
        if us <= 0:
            return
        self._stops.stand(us)
        if cause is None:
            self._producing += us
        else:
            self._lost[cause.loss] += us
            self._stops.book(cause, us, begin, self._now)
        if cause is None or WORDS[cause.loss].step is not Step.NOT_BUSY:
            self._troubles.stand(us)

    # --- folds ------------------------------------------------------------------------------

    def _take(self, event: e.Event) -> None:
        assert self._now is not None
        is_planned = self._planned.includes(self._now)
        span = self._standing.spans.follow(event)
        if isinstance(event, e.TaskFailed) and is_planned:
            self._troubles.failed(event, span)
        elif isinstance(event, e.HoldRaised):
            self._raised(event, is_planned=is_planned)
        elif isinstance(event, e.HoldReleased):
            self._troubles.released(event.hold)
        elif isinstance(event, e.ScriptLoaded):
            self._scripts[event.digest] = event.definition
        elif isinstance(event, e.OrchestratorStarted):
            self._started(event)
        self._standing.follow(event)
        self._stops.follow(event, self._now)
        counts = self._begin < self._now
        self._made.follow(event, counts=counts, is_planned=is_planned)

    def _raised(self, hold: e.HoldRaised, *, is_planned: bool) -> None:
        standing = self._standing
        if standing.is_emergency or not standing.has_node:
            return  # the goal was cancelled, its component has not failed
        cause = standing.cause()
        is_busy = cause is None or WORDS[cause.loss].step is not Step.NOT_BUSY
        self._troubles.raised(hold, is_busy=is_planned and is_busy)

    def _started(self, event: e.OrchestratorStarted) -> None:
        assert self._now is not None
        if self._now <= self._begin:
            self._cells.clear()  # what ran before the period is no matter
        self._cells[event.digest] = None
        self._cell = event.cell
