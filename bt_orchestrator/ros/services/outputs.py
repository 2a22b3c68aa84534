"""Outputs of the node: events topic, latched status, diagnostics."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from bt_orchestrator_interfaces.msg import CellDescription, Status
from bt_orchestrator_interfaces.msg import Event as EventMessage
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.engine.runtime.overview import Overview, description_of
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.events import (
    BeatStarted,
    BeltIndexed,
    BeltIndexStarted,
    CycleEvent,
    Event,
    ItemEvent,
    TaskEvent,
)
from bt_orchestrator.model.hold_words import hold_words
from bt_orchestrator.model.state import CellState
from bt_orchestrator.model.status_words import component_trouble
from bt_orchestrator.model.stop_reason import StopReason
from bt_orchestrator.model.uptime import Uptime
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.ros.clock import to_time
from bt_orchestrator.ros.executor.alarms import steady_timer
from bt_orchestrator.ros.executor.heart import Heart, Pulse
from bt_orchestrator.ros.qos import EVENTS, LATCHED, publisher
from bt_orchestrator.ros.services.expected_ends import ExpectedEnds
from bt_orchestrator.ros.services.reading_services import event_message
from bt_orchestrator.ros.standby import Standbys
from bt_orchestrator.ros.types.status_messages import StatusWriter, description_message

STATUS_PERIOD_S = 0.1
"""Shortest time between two status messages."""

PROGRESS = (TaskEvent, CycleEvent, ItemEvent, BeatStarted, BeltIndexStarted, BeltIndexed)
"""Events of the ordinary work, as opposed to orders, holds, decisions and states of the cell."""


class EventsTopic:
    """`~/events`: every durable record. Implements `ports.EventSink`."""

    def __init__(self, node: Node, history: str) -> None:
        self._history = history
        self._publisher = publisher(node, EventMessage, '~/events', EVENTS)

    def publish(self, events: Sequence[Event]) -> None:
        """Publish the records, in order; whoever comes later asks the journal (`~/get_events`)."""
        if not self._publisher.get_subscription_count():
            return
        for event in events:
            self._publisher.publish(event_message(event, self._history))


class StatusTopic:
    """`~/status`, latched: built outside the tick, at most ten times a second.

    Implements `ports.EventSink`. What happens hurries the next message on; while nothing does, or
    nobody listens to the ordinary work, it comes once a second. While the journal is waited for,
    the state is ahead of it: the last message is said again, and that the disk is waited for.
    """

    def __init__(
        self,
        node: Node,
        orchestrator: Orchestrator,
        overview: Overview,
        expected: ExpectedEnds,
        pulse: Pulse,
        uptime: Callable[[], Uptime],
    ) -> None:
        self._node = node
        self._uptime = uptime
        self._orchestrator = orchestrator
        self._overview = overview
        self._expected = expected
        self._publisher = publisher(node, Status, '~/status', LATCHED)
        self._writer = StatusWriter()
        self._last: Status | None = None
        """None: there is nothing yet that the journal holds."""
        self._timer = steady_timer(node, STATUS_PERIOD_S, self.publish_now)
        self._timer.cancel()
        pulse.add(self._refresh)

    def publish_now(self) -> None:
        """Publish the current status."""
        now = self._node.get_clock().now().nanoseconds / 1e9
        if not self._orchestrator.awaits_disk:
            status = self._overview.status(now, self._expected.within_s(now))
            self._last = self._writer.message(status)
        elif self._last is not None:
            self._last.stamp, self._last.uptime = to_time(now), self._uptime().seconds
            self._last.disk_wait = self._orchestrator.disk_wait
        if self._last is not None:
            self._publisher.publish(self._last)
        self._timer.cancel()

    def publish(self, events: Sequence[Event]) -> None:
        """Schedule a status that includes these events."""
        if self._timer.is_canceled() and not self._is_unheard(events):
            self._timer.reset()

    def _is_unheard(self, events: Sequence[Event]) -> bool:
        """Tell whether there is no listener to the ordinary work that these events are."""
        if self._publisher.get_subscription_count():
            return False
        return all(isinstance(event, PROGRESS) for event in events)

    def _refresh(self) -> None:
        """Publish once a second what no event has scheduled.

        Availability and feedback are no events, and who listens later sees the work until then.
        """
        if self._timer.is_canceled():
            self.publish_now()


class DescriptionTopic:
    """`~/cell`, latched: what exists, told once."""

    def __init__(self, node: Node, cell: Cell, types: ActionTypes) -> None:
        self._publisher = publisher(node, CellDescription, '~/cell', LATCHED)
        self._publisher.publish(description_message(description_of(cell, types)))


class Diagnostics:
    """`/diagnostics` at 1 Hz: the cell, and every component that is not as it should be."""

    def __init__(
        self,
        node: Node,
        orchestrator: Orchestrator,
        overview: Overview,
        heart: Heart,
        pulse: Pulse,
        standbys: Standbys | None = None,
    ) -> None:
        """Begin.

        :param standbys: the nodes that can take over; None: none can
        """
        self._node = node
        self._orchestrator = orchestrator
        self._overview = overview
        self._heart = heart
        self._standbys = standbys
        self._publisher = publisher(node, DiagnosticArray, '/diagnostics', 10)
        pulse.add(self._publish)

    def _publish(self) -> None:
        message = DiagnosticArray(status=[self._cell(), self._servers()])
        if self._standbys is not None:
            message.status.append(self._leadership(self._standbys))
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(message)

    def _cell(self) -> DiagnosticStatus:
        state = self._orchestrator.state
        level, text = DiagnosticStatus.OK, state.packml.value
        if state.stop_reason is not None:
            text = f'{state.packml.value}, {state.stop_reason.value}: {state.stop_message}'
            emergency = state.stop_reason is StopReason.EMERGENCY
            level = DiagnosticStatus.ERROR if emergency else DiagnosticStatus.WARN
        if self._orchestrator.broken:
            level, text = DiagnosticStatus.ERROR, self._orchestrator.broken
        elif self._heart.failures:
            level, text = DiagnosticStatus.ERROR, f'{self._heart.failures} settles failed'
        elif self._orchestrator.disk_wait:
            level, text = DiagnosticStatus.WARN, self._orchestrator.disk_wait
        return self._status('cell', level, text, self._values(state))

    def _values(self, state: CellState) -> dict[str, str]:
        now = self._node.get_clock().now().nanoseconds / 1e9
        values = {
            'state': state.packml.value,
            'in this state for (s)': f'{max(0.0, now - state.packml_since):.1f}',
            'stop reason': state.stop_reason.value if state.stop_reason else '',
            'seq': str(state.seq),
            'jobs': str(len(state.jobs)),
            'waits for the disk (s)': f'{self._orchestrator.disk_wait_s:.1f}',
        }
        values |= {f'time in {m.value} (s)': f'{s:.1f}' for m, s in state.times(now).items()}
        for hold in state.holds.values():
            values[f'hold {hold.id}'] = hold_words(hold)
        return values

    def _servers(self) -> DiagnosticStatus:
        components = tuple(self._overview.components())
        contested = {
            component.name: component.contested for component in components if component.contested
        }
        if contested:
            text = '; '.join(
                component_trouble(component) for component in components if component.contested
            )
            return self._status('action servers', DiagnosticStatus.ERROR, text, contested)
        out = {
            component.name: f'out of service, {component.out_of_service}'
            for component in components
            if component.out_of_service_since is not None
        }
        gone = [
            component
            for component in components
            if not (component.available or component.name in out)
        ]
        if not gone:
            text = f'all {len(components)} action servers are there'
            if out:
                text = f'out of service: {", ".join(out)}'
            return self._status('action servers', DiagnosticStatus.OK, text, out)
        text = f'{len(gone)} of {len(components)} action servers are not there'
        missing = {component.name: component.action for component in gone}
        return self._status('action servers', DiagnosticStatus.WARN, text, missing | out)

    def _leadership(self, standbys: Standbys) -> DiagnosticStatus:
        """Tell whether another node could take over."""
        leadership = standbys.leadership()
        troubles = {
            f'{standby.host}, process {standby.process}': standby.trouble
            for standby in leadership.standbys
        }
        able = [name for name, trouble in troubles.items() if not trouble]
        level, text = DiagnosticStatus.OK, f'leads; {", ".join(able)} can take over'
        if not able:
            is_lacking = standbys.wanted or troubles
            level = DiagnosticStatus.WARN if is_lacking else DiagnosticStatus.OK
            text = 'leads; no standby can take over'
        values = {'epoch': str(leadership.epoch)}
        values |= {f'standby {name}': trouble or 'ready' for name, trouble in troubles.items()}
        return self._status('leadership', level, text, values)

    def _status(
        self, part: str, level: bytes, text: str, values: dict[str, str]
    ) -> DiagnosticStatus:
        return DiagnosticStatus(
            level=level,
            name=f'{self._node.get_fully_qualified_name().lstrip("/")}: {part}',
            hardware_id=self._orchestrator.state.cell.name,
            message=text,
            values=[KeyValue(key=key, value=value) for key, value in values.items()],
        )
