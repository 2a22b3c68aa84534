"""The fold from events to what every moment is lost to, and what happens meanwhile.

It knows nothing of planned time: a ledger takes in what it says, and adds up what it wants.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Protocol

from bt_orchestrator.model import events as e
from bt_orchestrator.model.task_spans import TaskSpan
from bt_orchestrator.view.report.account.causes.items import FOLLOWED as OF_ITEMS
from bt_orchestrator.view.report.account.causes.items import ItemsAtWork
from bt_orchestrator.view.report.account.causes.made import Happening
from bt_orchestrator.view.report.account.losses import WORDS, Loss, Part, Step
from bt_orchestrator.view.report.account.planned import us_of
from bt_orchestrator.view.report.account.standing import FOLLOWED as OF_STANDING
from bt_orchestrator.view.report.account.standing import Cause, Standing
from bt_orchestrator.view.report.account.stops import Held, OpenHolds
from bt_orchestrator.view.report.line_stops import CodesGiven

_SIGNS = frozenset(
    (
        e.ComponentContested.event,
        e.ComponentSetupLost.event,
        e.ComponentSetupRead.event,
        e.OperatorRefused.event,
        e.RequestRefused.event,
        e.SafetyChanged.event,
        e.TaskAdopted.event,
        e.TaskCancelRequested.event,
        e.TaskResent.event,
    )
)
"""Events that change nothing here, and may be the last sign of a node that is killed then. All
others come at the same moment as one that is followed."""

FOLLOWED = (
    *sorted(_SIGNS),
    *OF_STANDING,
    *OF_ITEMS,
    e.OperatorDecided.event,
    e.ScriptLoaded.event,
    e.ClockStepped.event,
)
"""Names of the events that an account needs."""

EVER_US = 1 << 62
"""After any moment."""

_NOT_RECORDED = Cause(Loss.NOT_RECORDED)


def is_busy(cause: Cause | None) -> bool:
    """Tell whether time with a cause is busy time."""
    return cause is None or WORDS[cause.loss].step is not Step.NOT_BUSY


class Stretch(NamedTuple):
    """Time in which nothing changed."""

    begin: int
    end: int
    cause: Cause | None
    """Its loss; None: the line produced."""
    goes_on: bool
    """It was so just before, too."""
    seq: int = 0
    """Of the event with which the time of this cause began, without a break since."""
    since: int = 0
    """When that was."""
    working: tuple[str, ...] = ()
    """The components that operated."""
    code: str = ''
    """Of the reason that was given for it; empty: none so far."""


class Bookings(Protocol):
    """Books what a course says. Events of a moment come after the time before it."""

    def passes(self, stretch: Stretch) -> None:
        """Let time pass."""

    def raised(self, held: Held, *, is_busy: bool) -> None:
        """Take in a hold."""

    def released(self, held: Held) -> None:
        """Take in that a hold is over."""

    def failed(self, event: e.TaskFailed, span: TaskSpan | None) -> None:
        """Take in an attempt that failed."""

    def happened(self, what: Happening) -> None:
        """Take in what became of an item."""

    def runs(self, cell: str, digest: str) -> None:
        """Take in that a node began to run with a cell file."""


class Course:
    """Takes in one event after another, oldest first, and tells a ledger."""

    def __init__(self, *, is_whole: bool, begin: int | None = None) -> None:
        """Begin.

        :param is_whole: the first event that comes is the first of all
        :param begin: from when on time passes, if that is before the first event
        """
        self.now: int | None = None
        """Up to when time has passed; it never goes back."""
        self.cell = self.digest = ''
        """With which a node was started last."""
        self.holds = OpenHolds()
        self._begin = begin
        self._standing = Standing(is_whole=is_whole)
        self._since = 0
        """From when on."""
        self._items = ItemsAtWork()
        self._working: tuple[str, ...] | None = ()
        """The components with a goal in flight; None: that has to be looked up."""
        self._last: Cause | None = None
        """The loss of the time just before."""
        self._name = 0
        """The number of the event with which that began."""
        self._seq = 0
        """The number of the last event."""
        self._caused: tuple[Cause | None, int] = (_NOT_RECORDED, 0)
        """The loss after some event, and the number of the event that made it so."""
        self._codes = CodesGiven()

    @property
    def cause(self) -> Cause | None:
        """The loss since the last event; None: the line produces."""
        return self._standing.cause()

    @property
    def since(self) -> int:
        """From when on that is so."""
        return self._since if self.cause == self._last else self.now or 0

    @property
    def name(self) -> int:
        """The number of the event with which that began."""
        cause = self.cause
        return self._name if cause == self._last else self._caused_by(cause)

    def follow(self, event: e.Event, ledger: Bookings) -> None:
        """Take in the next event."""
        now = us_of(event.time)
        if self.now is None:
            self.now = now if self._begin is None else min(self._begin, now)
            self._pass(now, _NOT_RECORDED, 0, ledger)
        self.pass_until(event, ledger)
        if event.event not in _SIGNS:
            self._take(event, ledger)

    def pass_until(self, event: e.Event, ledger: Bookings, most: int = EVER_US) -> None:
        """Let the time pass up to an event, or to a moment before it; the event comes then.

        :param most: the moment
        """
        now, cause = us_of(event.time), self.cause
        seq = self._caused_by(cause)
        if isinstance(event, e.OrchestratorStarted) and self._standing.has_node:
            # A node that was killed says nothing; of the very first nothing was before.
            cause = self._standing.without_node() if cause != _NOT_RECORDED else cause
            seq = event.seq - 1
        elif isinstance(event, e.ClockStepped):
            # This event has the new time already; what really passed goes on from the old one.
            self._pass(min(most, now - us_of(event.seconds)), cause, seq, ledger)
            cause = _NOT_RECORDED
        self._pass(min(most, now), cause, seq, ledger)

    def rest(self, end: int) -> Stretch | None:
        """Return the time from now to a moment up to which no event comes; None: there is none."""
        if self.now is None:
            begin = end if self._begin is None else self._begin
            return Stretch(begin, end, _NOT_RECORDED, False) if begin < end else None
        cause = self.cause
        return self._stretch(end, cause, self._caused_by(cause))

    def _caused_by(self, cause: Cause | None) -> int:
        """Return the number of the event that made the present loss what it is."""
        if cause != self._caused[0]:
            self._caused = cause, self._seq
        return self._caused[1]

    def _pass(self, now: int, cause: Cause | None, seq: int, ledger: Bookings) -> None:
        """Let time pass; a clock that was set back makes nothing pass twice."""
        stretch = self._stretch(now, cause, seq)
        if stretch is not None:
            ledger.passes(stretch)
            self._since, self._name = stretch.since, stretch.seq
            self.now, self._last = now, cause

    def _stretch(self, end: int, cause: Cause | None, seq: int) -> Stretch | None:
        assert self.now is not None
        if self.now >= end:
            return None
        goes_on, code = cause == self._last, self._codes.of(cause)
        name, since = (self._name, self._since) if goes_on else (seq, self.now)
        return Stretch(self.now, end, cause, goes_on, name, since, self._operating(cause), code)

    def _operating(self, cause: Cause | None) -> tuple[str, ...]:
        """Return the components that operate: without a node that is not known."""
        if self._working is None:
            running = {span.component for span in self._standing.spans.open()}
            self._working = tuple(sorted(running))
        is_known = is_busy(cause) and (cause is None or cause.loss is not Loss.NO_NODE)
        return self._working if is_known else ()

    def _take(self, event: e.Event, ledger: Bookings) -> None:
        assert self.now is not None
        span = self._standing.spans.follow(event)
        if isinstance(event, e.TaskFailed):
            ledger.failed(event, span)
        if isinstance(event, (e.TaskStarted, e.TaskSucceeded, e.TaskFailed)):
            self._working = None
        elif isinstance(event, e.HoldRaised):
            self._raised(event, self.now, ledger)
        elif isinstance(event, e.OrchestratorStarted):
            self.cell, self.digest = event.cell, event.digest
            ledger.runs(self.cell, self.digest)
            # What stood before the node ended, and stands again, is another stop.
            self._caused = _NOT_RECORDED, event.seq
        self._standing.follow(event)
        self._codes.follow(event)
        self._seq = event.seq
        released = self.holds.follow(event, self.now)
        if released is not None:
            ledger.released(released)
        for what in self._items.follow(event, span):
            ledger.happened(what)

    def _raised(self, event: e.HoldRaised, now: int, ledger: Bookings) -> None:
        held = self.holds.raised(event, now, self._standing.failing(event))
        ledger.raised(held, is_busy=is_busy(self.cause))

    # --- kept and gone on from ----------------------------------------------------------------

    def plain(self) -> dict[str, Any]:
        """Return all that it knows, as JSON carries it."""
        return {
            'now': self.now,
            'cell': self.cell,
            'digest': self.digest,
            'since': self._since,
            'last': _plain_cause(self._last),
            'name': self._name,
            'seq': self._seq,
            'caused': [_plain_cause(self._caused[0]), self._caused[1]],
            'codes': self._codes.plain(),
            'standing': self._standing.plain(),
            'holds': self.holds.plain(),
            'items': self._items.plain(),
        }

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> Course:
        """Return a course that knows what another one knew."""
        made = cls(is_whole=False)
        made.now, made.cell, made.digest = plain['now'], plain['cell'], plain['digest']
        made._since, made._last = plain['since'], _cause_of(plain['last'])
        made._seq = plain['seq']
        if 'caused' in plain:  # books of older programs name no stop
            made._name, (caused, seq) = plain['name'], plain['caused']
            made._caused = _cause_of(caused), seq
            made._codes.go_on_from(plain.get('codes', {}))
        else:
            made._name, made._caused = made._seq, (made._last, made._seq)
        made._standing.go_on_from(plain['standing'])
        made.holds.go_on_from(plain['holds'])
        made._items.go_on_from(plain['items'])
        made._working = None
        return made


def _plain_cause(cause: Cause | None) -> list[str] | None:
    return None if cause is None else [cause.loss.value, *cause[1:4], cause.part.value]


def _cause_of(plain: Sequence[str] | None) -> Cause | None:
    if plain is None:
        return None
    loss, detail, component, hold = plain[:4]
    return Cause(Loss(loss), detail, component, hold, Part(*plain[4:]))
