"""The executor that the node spins on, one thread in either case (performance: executors)."""

from __future__ import annotations

from rclpy.executors import Executor, SingleThreadedExecutor

from bt_orchestrator.errors import OrchestratorError

SINGLE, EVENTS = 'single', 'events'


class UnknownExecutor(OrchestratorError):
    """The executor asked for does not exist, or not in this ROS 2 distribution."""


def make_executor(kind: str) -> Executor:
    """Return a new executor.

    :raises UnknownExecutor: there is none of that name here
    """
    if kind == SINGLE:
        return SingleThreadedExecutor()
    if kind != EVENTS:
        raise UnknownExecutor(f'parameter executor: expected single or events, found {kind!r}')
    try:
        from rclpy.experimental.events_executor import EventsExecutor
    except ImportError:
        raise UnknownExecutor(
            'parameter executor: this ROS 2 distribution has no events executor (Kilted and newer '
            'have it); use single'
        ) from None
    return EventsExecutor()
