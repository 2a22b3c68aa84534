"""The inspection server: services to open and close streams, and the turns that publish."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from py_trees_ros_interfaces import srv
from rclpy.node import Node

from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.ports.spare_log import SpareLog, guarded, report
from bt_orchestrator.ros.executor.alarms import steady_timer
from bt_orchestrator.ros.inspection import snapshot_source
from bt_orchestrator.ros.inspection.blackboard_streams import BlackboardStreams, View
from bt_orchestrator.ros.inspection.snapshot_source import (
    ActivityLog,
    SnapshotSource,
    TickStatistics,
)
from bt_orchestrator.ros.inspection.snapshot_streams import (
    DefaultStream,
    SnapshotStreams,
    StreamParameters,
    declare_default_stream,
)
from bt_orchestrator.ros.inspection.streams import StreamRefused
from bt_orchestrator.ros.services.patient_service import create_patient_service

TURN_S = 0.1
"""Shortest time between two snapshots."""


class InspectionServer:
    """Lets tree watchers look at the tree and the blackboard of a cell.

    The timer runs only while there are streams. Every call is answered: a refused `open` with an
    empty topic name, everything else that cannot be done with false.
    """

    def __init__(self, node: Node, orchestrator: Orchestrator, ticks: TickStatistics) -> None:
        """Offer the services, and open the default stream if the parameters say so."""
        self._logger = SpareLog(node.get_logger().get_child('inspection'))
        self._activity = ActivityLog()
        source = SnapshotSource(node, orchestrator, ticks, self._activity)
        self._snapshots = SnapshotStreams(node, source)
        self._blackboards = BlackboardStreams(node, source)
        self._pace = Pace()
        self._timer = steady_timer(node, TURN_S, guarded(self._turn, self._logger))
        self._serve(node, srv.OpenSnapshotStream, 'snapshot_streams/open', self._open)
        self._serve(node, srv.CloseSnapshotStream, 'snapshot_streams/close', self._close)
        self._serve(
            node, srv.ReconfigureSnapshotStream, 'snapshot_streams/reconfigure', self._reconfigure
        )
        self._serve(
            node,
            srv.GetBlackboardVariables,
            'blackboard_streams/get_variables',
            self._get_variables,
        )
        self._serve(node, srv.OpenBlackboardStream, 'blackboard_streams/open', self._open_text)
        self._serve(node, srv.CloseBlackboardStream, 'blackboard_streams/close', self._close_text)
        declare_default_stream(node, self._configure_default)
        self._run_if_needed()

    def _serve(self, node: Node, kind: Any, name: str, handle: Callable[[Any, Any], None]) -> None:
        def answer(request: Any, response: Any) -> Any:
            try:
                handle(request, response)
            except StreamRefused as refused:
                text = f'{name} refused: {refused}'
                self._logger.warning(text)
            except Exception:  # noqa: BLE001 - watchers wait for an answer without a time limit
                report(self._logger)
            self._run_if_needed()
            return response

        create_patient_service(node, kind, f'~/{name}', answer)

    # --- snapshots ----------------------------------------------------------------------------

    def _open(self, request: Any, response: Any) -> None:
        wanted = _parameters(request)
        response.topic_name = self._snapshots.open(request.topic_name, wanted, time.monotonic())

    def _close(self, request: Any, response: Any) -> None:
        response.result = self._snapshots.close(request.topic_name)

    def _reconfigure(self, request: Any, response: Any) -> None:
        response.result = self._snapshots.reconfigure(request.topic_name, _parameters(request))

    def _configure_default(self, wanted: DefaultStream) -> None:
        self._snapshots.configure_default(wanted, time.monotonic())
        self._run_if_needed()

    # --- blackboard ---------------------------------------------------------------------------

    def _get_variables(self, _request: Any, response: Any) -> None:
        response.variables = snapshot_source.blackboard_variables()

    def _open_text(self, request: Any, response: Any) -> None:
        view = View(
            tuple(name for name in request.variables if name),
            request.filter_on_visited_path,
            request.with_activity_stream,
        )
        response.topic = self._blackboards.open(view, time.monotonic())

    def _close_text(self, request: Any, response: Any) -> None:
        response.result = self._blackboards.close(request.topic_name)

    # --- turns --------------------------------------------------------------------------------

    def _run_if_needed(self) -> None:
        streams = (self._snapshots, self._blackboards)
        self._activity.record(wanted=any(kind.wants_activity for kind in streams))
        if not any(len(kind) for kind in streams):
            self._timer.cancel()
        elif self._timer.is_canceled():
            self._timer.reset()

    def _turn(self) -> None:
        now = time.monotonic()
        if not self._pace.may_begin(now):
            return
        with self._pace.turn(now):
            self._snapshots.look(now)
            self._blackboards.look(now)
            self._activity.collect()
            self._snapshots.publish_due(now)
            self._blackboards.publish_due()
        self._run_if_needed()


def _parameters(request: Any) -> StreamParameters:
    wanted = request.parameters
    return StreamParameters(
        wanted.snapshot_period, wanted.blackboard_data, wanted.blackboard_activity
    )


# How much of the thread's time publishing for watchers may take.

SHARE = 0.05
"""Largest part of the thread's time that publishing may take: a large tree is shown less often."""

AFTER_ERROR_S = 1.0
"""When to try again after a turn that failed."""


class Pace:
    """Says after each turn when the next one may begin.

    What a turn has taken is counted in time of the processor. By the clock it may have taken a
    hundred times as long, where other programs had their turn meanwhile; after a pause of twenty
    times that, watchers would have missed whole jobs.
    """

    def __init__(self, used_s: Callable[[], float] = time.thread_time) -> None:
        """Allow a turn.

        :param used_s: returns the seconds that the processor has worked for this thread
        """
        self._used_s = used_s
        self._resume_at = -math.inf

    def may_begin(self, now: float) -> bool:
        """Tell whether a turn may begin.

        :param now: seconds, of a clock that does not jump
        """
        return now >= self._resume_at

    @contextmanager
    def turn(self, now: float) -> Iterator[None]:
        """Count what is done within as a turn that began now."""
        self._resume_at = now + AFTER_ERROR_S
        used_s = self._used_s()
        yield
        self._resume_at = now + (self._used_s() - used_s) / SHARE
