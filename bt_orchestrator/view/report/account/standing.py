"""The fold that says at every moment what the time is lost to, if it is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import from_record, to_plain, to_record
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.stop_reason import StopReason
from bt_orchestrator.model.task_spans import TaskSpans
from bt_orchestrator.view.report.account.losses import OF_STOP_REASON, Loss
from bt_orchestrator.view.report.account.orders_at_hand import FOLLOWED as OF_ORDERS
from bt_orchestrator.view.report.account.orders_at_hand import OrdersAtHand


class Cause(NamedTuple):
    """The loss of a moment."""

    loss: Loss
    detail: str = ''
    """The exact cause, without items and numbers: equal stops can be summed up."""
    component: str = ''
    hold: str = ''
    """The hold that it waits for; empty: none."""


class Standing:
    """Takes in one event after another. The order of precedence is that of docs/account.md."""

    def __init__(self, *, is_whole: bool) -> None:
        """Begin.

        :param is_whole: the first event is the first of all: the cell is Stopped and empty
        """
        self.spans = TaskSpans()
        self.holds: dict[str, e.HoldRaised] = {}
        """Those that stand, in the order in which they were raised."""
        self._state = PackmlState.STOPPED if is_whole else None
        self._stop_reason: StopReason | None = None
        self._stop_words = ''
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

    def cause(self) -> Cause | None:
        """Return what the time from here on is lost to; None: the line produces."""
        if self._state is None:
            return Cause(Loss.NOT_RECORDED)
        if not self._orders.any:
            return self._without_work()
        if self._node_ended:
            return Cause(Loss.NO_NODE)
        if self._stop_reason is not None:
            return self._stopped(self._stop_reason)
        if not self._state.begins:
            return Cause(Loss.OPERATOR, f'the cell was {self._state.value}')
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
        if not self.holds:
            return Cause(loss, self._stop_words if reason is StopReason.OPERATOR else '')
        hold = next(iter(self.holds.values()))
        return Cause(loss, kind_of(hold), hold.component, hold.hold)

    def _at_work(self) -> Cause | None:
        running = list(self.spans.open())
        if not running:
            if self._orders.all_paused:
                return Cause(Loss.OPERATOR, 'job paused')
            first = next(iter((*self._out, *self._unready)), '')
            return Cause(Loss.WAITING, self._trouble(), first)
        if all(one.section is None and one.job is not None for one in running):
            return Cause(Loss.SETUP, 'initialization')
        again = next((one for one in running if one.attempt > 1 or one.round), None)
        if again is not None:
            return Cause(Loss.REWORK, f'{again.name} again', again.component)
        return None

    def _trouble(self) -> str:
        """Say which components could not work."""
        said = [f'{", ".join(self._out)} out of service'] if self._out else []
        unready = [name for name in self._unready if name not in self._out]
        said += [f'{", ".join(unready)} not ready'] if unready else []
        return '; '.join(said) or 'nothing could start'

    # --- folds ------------------------------------------------------------------------------

    def follow(self, event: e.Event) -> None:
        """Take in the next event."""
        self._orders.follow(event)
        if isinstance(event, e.CellStateChanged):
            self._state = PackmlState(event.state)
        elif isinstance(event, e.StopReasonChanged):
            self._stop_reason = StopReason(event.stop_reason) if event.stop_reason else None
            self._stop_words = event.reason
        elif isinstance(event, e.HoldRaised):
            self.holds[event.hold] = event
        elif isinstance(event, e.HoldReleased):
            self.holds.pop(event.hold, None)
        elif isinstance(event, e.OrchestratorStopping):
            self._node_ended = True
        elif isinstance(event, e.OrchestratorStarted):
            self._node_ended = False
        else:
            self._component(event)

    def plain(self) -> dict[str, Any]:
        """Return what it knows, as JSON carries it."""
        return {
            'spans': [to_record(one) for one in self.spans.open()],
            'holds': [to_record(one) for one in self.holds.values()],
            'state': to_plain(self._state),
            'stop_reason': to_plain(self._stop_reason),
            'stop_words': self._stop_words,
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
        state, reason = plain['state'], plain['stop_reason']
        self._state = None if state is None else PackmlState(state)
        self._stop_reason = None if reason is None else StopReason(reason)
        self._stop_words = plain['stop_words']
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
    e.HoldRaised.event,
    e.HoldReleased.event,
    e.OrchestratorStarted.event,
    e.OrchestratorStopping.event,
    e.ComponentStateChanged.event,
    e.TaskStarted.event,
    e.TaskSucceeded.event,
    e.TaskFailed.event,
)
