"""The fold that says at every moment what the time is lost to, and whether there is work."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import from_record, to_plain, to_record
from bt_orchestrator.model.packml import PackmlState, UnitMode
from bt_orchestrator.model.stop_reason import StopReason
from bt_orchestrator.model.task_spans import TaskSpans
from bt_orchestrator.view.report.account.losses import OF_STOP_REASON, Loss, Part
from bt_orchestrator.view.report.account.stops import failing_component

# The fold that knows whether there is work: a job on the line, or one that could start.


@dataclass
class _Order:
    started: bool = False
    held: bool = False
    awaits_start: bool = False
    paused: bool = False
    unreleased: str = ''
    """Digest of its script, if that is not released."""
    lacks: set[str] = field(default_factory=set)

    @property
    def waits_for(self) -> tuple[str, ...]:
        """The obstacles to its start, in words."""
        why = {
            'held in the queue': self.held,
            'before its start': self.awaits_start,
            'script not released': self.unreleased,
            f'{", ".join(sorted(self.lacks))} out of service': self.lacks,
        }
        return tuple(words for words, is_so in why.items() if is_so and not self.started)

    @property
    def is_at_hand(self) -> bool:
        waits = self.held or self.awaits_start or self.unreleased or self.lacks
        return self.started or not waits


class OrdersAtHand:
    """Takes in one event after another; knows the jobs that have not ended, and nothing more."""

    def __init__(self) -> None:
        self._orders: dict[str, _Order] = {}

    @property
    def any(self) -> bool:
        """Tell whether there is work (as `CellState.has_work`)."""
        return any(order.is_at_hand for order in self._orders.values())

    @property
    def waits_for(self) -> str:
        """The obstacles to the start of all orders; empty: there is no order."""
        return '; '.join(
            sorted({why for order in self._orders.values() for why in order.waits_for})
        )

    @property
    def all_paused(self) -> bool:
        """Tell whether there are jobs on the line, and an operator has paused all of them."""
        line = [order.paused for order in self._orders.values() if order.started]
        return bool(line) and all(line)

    def follow(self, event: e.Event) -> None:
        """Take in the next event."""
        if isinstance(event, e.OrderEvent):
            self._queued(event)
        elif isinstance(event, e.ComponentOutOfService):
            for job in event.jobs:
                self._orders.setdefault(job, _Order()).lacks.add(event.component)
        elif isinstance(event, e.ComponentInService):
            for job_order in self._orders.values():
                job_order.lacks.discard(event.component)
        elif isinstance(event, e.ScriptReleased):
            for job_order in self._orders.values():
                if job_order.unreleased == event.digest:
                    job_order.unreleased = ''
        elif isinstance(event, _LEAVES):
            self._orders.pop(event.job, None)
        elif isinstance(event, _CHANGES):
            order = self._orders.setdefault(event.job, _Order())
            vars(order).update(_VALUES[type(event)])

    def plain(self) -> dict[str, Any]:
        """Return what it knows, as JSON carries it."""
        return {
            job: {**vars(order), 'lacks': sorted(order.lacks)}
            for job, order in self._orders.items()
        }

    def go_on_from(self, plain: Mapping[str, Any]) -> None:
        """Know what another one knew."""
        self._orders = {
            job: _Order(**{**order, 'lacks': set(order['lacks'])}) for job, order in plain.items()
        }

    def _queued(self, event: e.OrderEvent) -> None:
        order = self._orders.setdefault(event.job, _Order())
        if isinstance(event, e.JobQueued):
            order.held = event.held
        order.awaits_start, order.lacks = event.awaits_start, set(event.unavailable)
        order.unreleased = event.digest if event.awaits_release else ''


_LEAVES = (e.JobRemoved, e.JobCompleted, e.JobAborted)

_CHANGES = (
    e.JobStarted,
    e.JobHeld,
    e.JobReleased,
    e.JobMayStart,
    e.JobPaused,
    e.JobResumed,
    e.JobStopping,
    e.JobAborting,
)

_VALUES: Mapping[type[e.Event], Mapping[str, object]] = {
    e.JobStarted: {'started': True},
    e.JobHeld: {'held': True},
    e.JobReleased: {'held': False},
    e.JobMayStart: {'awaits_start': False},
    e.JobPaused: {'paused': True},
    e.JobResumed: {'paused': False},
    e.JobStopping: {'paused': False},
    # It has to end, also if it never began.
    e.JobAborting: {'started': True, 'held': False, 'awaits_start': False, 'paused': False},
}

OF_ORDERS = (
    *(kind.event for kind in (e.JobQueued, e.JobUpdated)),
    *(kind.event for kind in _CHANGES),
    *(kind.event for kind in _LEAVES),
    e.ComponentOutOfService.event,
    e.ComponentInService.event,
    e.ScriptReleased.event,
)


# The fold that says at every moment what the time is lost to, if it is.


JOB_PAUSED = 'job paused'
"""The detail where every job on the line is paused, and nothing runs."""


class Cause(NamedTuple):
    """The loss of a moment."""

    loss: Loss
    detail: str = ''
    """The exact cause, without items and numbers: equal stops can be summed up."""
    component: str = ''
    hold: str = ''
    """The hold that it waits for; empty: none."""
    part: Part = Part.WHOLE


class Standing:
    """Takes in one event after another. The order of precedence is that of docs/account.md."""

    def __init__(self, *, is_whole: bool) -> None:
        """Begin.

        :param is_whole: the first event is the first of all: the cell is Stopped and empty
        """
        self.spans = TaskSpans()
        self.holds: dict[str, e.HoldRaised] = {}
        """Those that stand, in the order in which they were raised."""
        self._failures: set[str] = set()
        """Those that are failures of their components."""
        self._state = PackmlState.STOPPED if is_whole else None
        self._stop_reason: StopReason | None = None
        self._stop_words = ''
        self._is_manual = False
        self._node_ended = False
        self._orders = OrdersAtHand()
        self._unready: dict[str, None] = {}
        self._out: dict[str, None] = {}

    @property
    def is_emergency(self) -> bool:
        """Tell whether `abort` was commanded, and `clear` was not since."""
        return self._stop_reason is StopReason.EMERGENCY

    @property
    def has_node(self) -> bool:
        """Tell whether the node has not begun to end."""
        return not self._node_ended

    def failing(self, hold: e.HoldRaised) -> str:
        """Return the component whose failure a hold is that is raised now; empty: none is.

        Where the goal was cancelled its component has not failed.
        """
        return '' if self.is_emergency or self._node_ended else failing_component(hold)

    def cause(self) -> Cause | None:
        """Return what the time from here on is lost to; None: the line produces."""
        if self._state is None:
            return Cause(Loss.NOT_RECORDED)
        if not self._orders.any:
            return self._without_work()
        if self._node_ended:
            return Cause(Loss.NO_NODE)
        if self._is_manual and not self.is_emergency:
            return Cause(Loss.OPERATOR, 'manual mode', part=Part.MANUAL)
        if self._stop_reason is not None:
            return self._stopped(self._stop_reason)
        if not self._state.begins:
            words = f'the cell was {self._state.value}'
            return Cause(Loss.OPERATOR, words, part=Part.NOT_STARTED)
        return self._at_work()

    def without_node(self) -> Cause:
        """Return what the time was lost to before a node that was not heard to end started."""
        return Cause(Loss.NO_NODE) if self._orders.any else self._without_work()

    def _without_work(self) -> Cause:
        waits = self._orders.waits_for
        return Cause(Loss.ORDERS_WAIT, waits) if waits else Cause(Loss.NO_ORDER)

    def _stopped(self, reason: StopReason) -> Cause:
        loss = OF_STOP_REASON[reason]
        if reason in (StopReason.STARVED, StopReason.BLOCKED):
            return Cause(loss, self._trouble(), next(iter(self._unready), ''))
        if reason is StopReason.EMERGENCY:
            return Cause(loss, 'abort')
        is_operator = reason is StopReason.OPERATOR
        if not self.holds:
            part = Part.NOT_STARTED if is_operator else Part.ANSWER
            return Cause(loss, self._stop_words if is_operator else '', part=part)
        hold = next(iter(self.holds.values()))
        part = Part.FAULT if hold.hold in self._failures else Part.ANSWER
        about = (kind_of(hold), hold.component, hold.hold)
        return Cause(loss, *about, Part.PAUSED if is_operator else part)

    def _at_work(self) -> Cause | None:
        running = list(self.spans.open())
        if not running:
            if self._orders.all_paused:
                return Cause(Loss.OPERATOR, JOB_PAUSED, part=Part.PAUSED)
            first = next(iter((*self._out, *self._unready)), '')
            return Cause(Loss.WAITING, self._trouble(), first)
        if all(span.section is None and span.job is not None for span in running):
            return Cause(Loss.SETUP, 'initialization')
        again = next((span for span in running if span.attempt > 1 or span.round), None)
        if again is not None:
            return Cause(Loss.REWORK, f'{again.name} again', again.component)
        return None

    def _trouble(self) -> str:
        """Say which components could not work."""
        troubles = [f'{", ".join(self._out)} out of service'] if self._out else []
        unready = [name for name in self._unready if name not in self._out]
        troubles += [f'{", ".join(unready)} not ready'] if unready else []
        return '; '.join(troubles) or 'nothing could start'

    # --- folds ------------------------------------------------------------------------------

    def follow(self, event: e.Event) -> None:
        """Take in the next event."""
        self._orders.follow(event)
        if isinstance(event, e.CellStateChanged):
            self._state = PackmlState(event.state)
        elif isinstance(event, e.StopReasonChanged):
            self._stop_reason = StopReason(event.stop_reason) if event.stop_reason else None
            self._stop_words = event.reason
        elif isinstance(event, e.UnitModeChanged):
            self._is_manual = event.mode == UnitMode.MANUAL.value
        elif isinstance(event, e.HoldRaised):
            if self.failing(event):
                self._failures.add(event.hold)
            self.holds[event.hold] = event
        elif isinstance(event, e.HoldReleased):
            self.holds.pop(event.hold, None)
            self._failures.discard(event.hold)
        elif isinstance(event, e.OrchestratorStopping):
            self._node_ended = True
        elif isinstance(event, e.OrchestratorStarted):
            self._node_ended = False
        else:
            self._component(event)

    def plain(self) -> dict[str, Any]:
        """Return what it knows, as JSON carries it."""
        return {
            'spans': [to_record(span) for span in self.spans.open()],
            'holds': [to_record(hold) for hold in self.holds.values()],
            'failures': sorted(self._failures),
            'state': to_plain(self._state),
            'stop_reason': to_plain(self._stop_reason),
            'stop_words': self._stop_words,
            'is_manual': self._is_manual,
            'node_ended': self._node_ended,
            'orders': self._orders.plain(),
            'unready': list(self._unready),
            'out': list(self._out),
        }

    def go_on_from(self, plain: Mapping[str, Any]) -> None:
        """Know what another one knew."""
        for record in plain['spans']:
            self.spans.follow(from_record(record))
        for record in plain['holds']:
            hold = from_record(record)
            assert isinstance(hold, e.HoldRaised)
            self.holds[hold.hold] = hold
        self._failures = set(plain.get('failures', ()))
        state, reason = plain['state'], plain['stop_reason']
        self._state = None if state is None else PackmlState(state)
        self._stop_reason = None if reason is None else StopReason(reason)
        self._stop_words = plain['stop_words']
        self._is_manual = plain.get('is_manual', False)
        self._node_ended = plain['node_ended']
        self._orders.go_on_from(plain['orders'])
        self._unready = dict.fromkeys(plain['unready'])
        self._out = dict.fromkeys(plain['out'])

    def _component(self, event: e.Event) -> None:
        if isinstance(event, e.ComponentStateChanged):
            _set(self._unready, event.component, is_in=not event.ready)
        elif isinstance(event, e.ComponentOutOfService):
            _set(self._out, event.component, is_in=True)
        elif isinstance(event, e.ComponentInService):
            _set(self._out, event.component, is_in=False)


def kind_of(hold: e.HoldRaised) -> str:
    """Say what kind of hold it is, without its item."""
    if hold.component:
        return f'{hold.name or hold.task} {hold.reason}'
    return hold.reason


def _set(names: dict[str, None], name: str, *, is_in: bool) -> None:
    if is_in:
        names[name] = None
    else:
        names.pop(name, None)


FOLLOWED = (
    *OF_ORDERS,
    e.CellStateChanged.event,
    e.StopReasonChanged.event,
    e.UnitModeChanged.event,
    e.HoldRaised.event,
    e.HoldReleased.event,
    e.OrchestratorStarted.event,
    e.OrchestratorStopping.event,
    e.ComponentStateChanged.event,
    e.TaskStarted.event,
    e.TaskSucceeded.event,
    e.TaskFailed.event,
)
