"""The executor that the node spins on, one thread in any case."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.context import Context
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.task import Future

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.ros.executor.ways import Way
from bt_orchestrator.ros.node_parameters import SINGLE

MOMENT_S = 0.1
"""Longest time for which an EventsExecutor spins without looking up."""


class NoEventsExecutor(OrchestratorError):
    """The rclpy of this ROS 2 distribution has none."""


def make_executor(kind: str, way: Way, context: Context | None = None) -> Executor:
    """Return a new executor.

    :raises NoEventsExecutor: it was asked for, and cannot be had
    """
    if kind == SINGLE:
        return way.executor(context=context)
    try:
        from rclpy.experimental.events_executor import EventsExecutor
    except ImportError:
        raise NoEventsExecutor(
            'parameter executor: the rclpy installed here has no events executor; use single'
        ) from None
    return EventsExecutor(context=context)


def soon(executor: Executor, call: Callable[[], None]) -> None:
    """Let an executor call something before it waits again.

    EventsExecutor refuses guard conditions, so that it is a task there, and in the plain way.
    """
    getattr(executor, 'soon', executor.create_task)(call)


def spin_once(executor: Executor, timeout_s: float | None = None) -> None:
    """Let an executor work: at least one callback, or until the timeout.

    EventsExecutor's own `spin` and `spin_once` never wait in the wheels of Kilted: they use a
    whole core, and timers and signals come late or never. Waiting for a future is sound; here it
    is one that never comes, for a moment at a time.
    """
    if isinstance(executor, SingleThreadedExecutor):
        executor.spin_once(timeout_sec=timeout_s)
        return
    moment_s = MOMENT_S if timeout_s is None else min(timeout_s, MOMENT_S)
    never: Future[None] = Future(executor=executor)
    executor.spin_until_future_complete(never, timeout_sec=moment_s)
