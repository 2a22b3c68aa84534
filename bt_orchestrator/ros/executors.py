"""The executor that the node spins on, one thread in either case (performance: executors)."""

from __future__ import annotations

import threading
from typing import Any

from rclpy.context import Context
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.guard_condition import GuardCondition
from rclpy.task import Future

from bt_orchestrator.errors import OrchestratorError
from bt_orchestrator.node_parameters import SINGLE

MOMENT_S = 0.1
"""Longest time for which an EventsExecutor spins without looking up."""


class NoEventsExecutor(OrchestratorError):
    """The rclpy of this ROS 2 distribution has none."""


class LeanExecutor(SingleThreadedExecutor):
    """rclpy's executor for one thread, without the turns in which nothing can be ready.

    rclpy wakes its executor twice in each callback, for threads that might wait meanwhile. Here
    none does: the thread that would be woken is the one that runs the callback. But its next wait
    then returns at once with nothing, and each wait asks every entity of the node.
    """

    def __init__(self, *, context: Context | None = None) -> None:
        super().__init__(context=context)
        assert self._guard is not None
        self._guard.destroy()
        self._guard = self._others = _GuardForOthers(context)

    def wait_for_ready_callbacks(self, *args: Any, **kwargs: Any) -> Any:
        """Return the next callback to run; tasks that were made meanwhile come before a wait."""
        self._others.spinner = threading.get_ident()
        return super().wait_for_ready_callbacks(*args, **kwargs)


class _GuardForOthers(GuardCondition):
    """Wakes the executor, unless it is the executor's own thread that asks for it."""

    def __init__(self, context: Context | None) -> None:
        super().__init__(callback=None, callback_group=None, context=context)
        self.spinner: int | None = None
        """The thread that waits, and looks for tasks before it does."""

    def trigger(self) -> None:
        """Wake a wait in another thread."""
        if threading.get_ident() != self.spinner:
            super().trigger()


def make_executor(kind: str) -> Executor:
    """Return a new executor.

    :raises NoEventsExecutor: it was asked for, and cannot be had
    """
    if kind == SINGLE:
        return LeanExecutor()
    try:
        from rclpy.experimental.events_executor import EventsExecutor
    except ImportError:
        raise NoEventsExecutor(
            'parameter executor: the rclpy installed here has no events executor; use single'
        ) from None
    return EventsExecutor()


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
