"""rclpy's executor for one thread, at less cost. It knows its inside."""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any

from rclpy.context import Context
from rclpy.executors import (
    ConditionReachedException,
    ExternalShutdownException,
    ShutdownException,
    SingleThreadedExecutor,
    TimeoutException,
    TimeoutObject,
)
from rclpy.guard_condition import GuardCondition
from rclpy.node import Node

from bt_orchestrator.ros.executor.lean_waits import (
    CLIENT,
    FOR_EVER_NS,
    GUARD,
    OFTEN,
    PARTED,
    SERVICE,
    SUBSCRIPTION,
    TIMER,
    WAITABLE,
    Member,
    SeldomReady,
    WaitList,
)

_NS_PER_S = 1_000_000_000


class LeanExecutor(SingleThreadedExecutor):
    """Runs the same callbacks, and does less between them.

    - rclpy wakes its executor twice in each callback, for threads that might wait meanwhile. Here
      none does: the thread that would be woken is the one that runs the callback. But its next
      wait then returns at once with nothing, and each wait asks every entity of the node.
    - Each wait of rclpy's begins with nothing known; here what is waited for is kept.
    - Services are waited for apart: they are many, and seldom asked.
    - A `PartedWaitable` runs without a task of rclpy's around it.
    """

    def __init__(self, *, context: Context | None = None) -> None:
        super().__init__(context=context)
        assert self._guard is not None
        self._guard.destroy()
        self._guard = self._others = _GuardForOthers(context)
        self._soon: deque[Callable[[], None]] = deque()
        self._wait_list = self._often(())
        self._seldom = SeldomReady(self._others.trigger, self._context)
        self._take: dict[str, Callable[[Any], Any]] = {
            WAITABLE: self._take_waitable,
            TIMER: self._take_timer,
            SUBSCRIPTION: self._take_subscription,
            GUARD: self._take_guard_condition,
            CLIENT: self._take_client,
            SERVICE: self._take_service,
        }

    def soon(self, call: Callable[[], None]) -> None:
        """Call something before the next wait; may be asked for by any thread.

        What such a call asks for comes after a look at the others, which waits for nothing: a call
        that goes on in pieces keeps nobody from being served.

        :param call: raises nothing
        """
        self._soon.append(call)
        self._others.trigger()

    def wait_for_ready_callbacks(self, *args: Any, **kwargs: Any) -> Any:
        """Return the next callback to run; what was asked for meanwhile comes before a wait."""
        self._others.spinner = threading.get_ident()
        return super().wait_for_ready_callbacks(*args, **kwargs)

    def shutdown(self, timeout_sec: float | None = None) -> bool:
        """End, and let go of what was waited for."""
        ended = super().shutdown(timeout_sec)
        self._wait_list.close()
        self._seldom.close()
        return ended

    def _wait_for_ready_callbacks(
        self,
        timeout_sec: float | TimeoutObject | None = None,
        nodes: list[Node] | None = None,
        condition: Callable[[], bool] = lambda: False,
    ) -> Any:
        """Yield what to run: what was asked for and, once no task gets on, what a wait finds.

        Whoever runs it begins again at its end.

        :raises TimeoutException: nothing came
        """
        assert nodes is None, 'it waits for the nodes that were added'
        if self._soon:
            yield _PlainTurn(self._call_soon), None, None
        while True:
            tasks = self._open_tasks()
            yield from tasks
            if any(task.done() for task, _, _ in tasks):
                return  # it may have made others, or what another one awaits
            ready = self._wait(_deadline(timeout_sec), condition)
            if [entry.kind for entry in ready] != [PARTED] or not ready[0].may_run():
                break
            # What an answer asks for comes in its turn: to begin another one takes 0.03 ms.
            yield _PlainTurn(ready[0].entity.run, self._call_soon), ready[0].entity, ready[0].node
        while ready:
            entry = ready.pop(0)
            if entry.may_run():
                yield self._turn(entry), entry.entity, entry.node
            if ready and self._follow_nodes():
                # The others have their turn all the same: one that changes the entities each time,
                # and is ready again, would come first for ever.
                ready = [other for other in ready if self._is_there(other)]

    def _open_tasks(self) -> Sequence[Any]:
        with self._tasks_lock:
            self._tasks = [
                entry for entry in self._tasks if not (entry[0].done() or entry[0].cancelled())
            ]
            return tuple(self._tasks)

    def _turn(self, entry: Member) -> Any:
        if entry.kind == PARTED:
            return _PlainTurn(entry.entity.run)
        return self._make_handler(entry.entity, entry.node, self._take[entry.kind])

    def _call_soon(self) -> None:
        for _ in range(len(self._soon)):
            self._soon.popleft()()

    def _wait(self, until: float, condition: Callable[[], bool]) -> list[Member]:
        """Return what is ready; nothing if something else is to run.

        :param until: when to give up, on the steady clock
        """
        while True:
            if self._is_shutdown:
                raise ShutdownException
            if condition():
                raise ConditionReachedException
            self._follow_nodes()
            self._seldom.go_on()
            left_ns = 0 if self._soon else _left_ns(until)
            ready = self._wait_list.wait(left_ns, self._wait_list.busy())
            ready += self._seldom.take()
            if self._is_shutdown:
                raise ShutdownException
            if not self._context.ok():
                raise ExternalShutdownException
            if ready or self._tasks or self._soon:
                return ready
            if time.monotonic() >= until:
                raise TimeoutException

    def _follow_nodes(self) -> bool:
        """Wait for what the nodes have now; tell whether that has changed."""
        nodes = self.get_nodes()
        if self._wait_list.is_of(nodes):
            return False
        self._wait_list.close()
        self._wait_list = self._often(nodes)
        self._seldom.follow(nodes)
        return True

    def _is_there(self, member: Member) -> bool:
        return self._wait_list.has(member) or self._seldom.has(member)

    def _often(self, nodes: Sequence[Node]) -> WaitList:
        own = [guard for guard in (self._guard, self._sigint_gc) if guard is not None]
        return WaitList(nodes, own, self._context, OFTEN)


class _PlainTurn:
    """A turn without a task of rclpy's: calls that await nothing and raise nothing."""

    def __init__(self, *calls: Callable[[], None]) -> None:
        self._calls = calls

    def __call__(self) -> None:
        for call in self._calls:
            call()

    def exception(self) -> None:
        """Return None: it raised nothing (rclpy asks after each turn)."""

    def result(self) -> None:
        """Return nothing (rclpy asks after each turn)."""


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


def _deadline(timeout_sec: float | TimeoutObject | None) -> float:
    """Return the time on the steady clock at which a timeout of rclpy's is over."""
    seconds = timeout_sec.timeout if isinstance(timeout_sec, TimeoutObject) else timeout_sec
    return math.inf if seconds is None or seconds < 0 else time.monotonic() + seconds


def _left_ns(until: float) -> int:
    """Return how long to wait; a negative number means without limit."""
    if until == math.inf:
        return FOR_EVER_NS
    return max(0, round((until - time.monotonic()) * _NS_PER_S))
