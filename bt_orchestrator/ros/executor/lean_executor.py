"""rclpy's executor for one thread, at less cost. It knows its inside."""

from __future__ import annotations

import math
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence, Sized
from functools import partial
from typing import Any, NamedTuple

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
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.waitable import NumberOfEntities

from bt_orchestrator.ros.executor.lean_parts import LISTS, Part, PartedWaitable

_NS_PER_S = 1_000_000_000
_FOR_EVER_NS = -1


class LeanExecutor(SingleThreadedExecutor):
    """Runs the same callbacks, and does less between them.

    - rclpy wakes its executor twice in each callback, for threads that might wait meanwhile. Here
      none does: the thread that would be woken is the one that runs the callback. But its next
      wait then returns at once with nothing, and each wait asks every entity of the node.
    - Each wait of rclpy's begins with nothing known; here what is waited for is kept.
    - A `PartedWaitable` runs without a task of rclpy's around it.
    """

    def __init__(self, *, context: Context | None = None) -> None:
        super().__init__(context=context)
        assert self._guard is not None
        self._guard.destroy()
        self._guard = self._others = _GuardForOthers(context)
        self._soon: deque[Callable[[], None]] = deque()
        self._wait_list = WaitList((), self._own_guards(), self._context)
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
                ready = [other for other in ready if self._wait_list.has(other)]

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
            ready = self._wait_list.wait(0 if self._soon else _left_ns(until))
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
        self._wait_list = WaitList(nodes, self._own_guards(), self._context)
        return True

    def _own_guards(self) -> Sequence[GuardCondition]:
        return [guard for guard in (self._guard, self._sigint_gc) if guard is not None]


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
        return _FOR_EVER_NS
    return max(0, round((until - time.monotonic()) * _NS_PER_S))


# The things that an executor waits for, kept from one wait to the next.

WAITABLE = 'waitable'
"""Several entities that are asked together, such as an action server."""
PARTED = 'parted waitable'
"""Several service clients, with the answers that came for each."""
GUARD = 'guard_condition'
TIMER = 'timer'
SUBSCRIPTION = 'subscription'
CLIENT = 'client'
SERVICE = 'service'


class Member(NamedTuple):
    """An entity of a node."""

    kind: str
    """As rclpy's wait set calls it, or WAITABLE or PARTED."""
    entity: Any
    node: Node

    def may_run(self) -> bool:
        """Tell whether it is to run now; a timer may have been cancelled since it was ready."""
        if self.kind == TIMER and not self.entity.handle.is_timer_ready():
            return False
        return bool(self.entity.callback_group.can_execute(self.entity))


class WaitList:
    """The entities of some nodes, and a wait set that holds all of them.

    rclpy gathers the entities anew for each wait, asks each whether it may run, locks it, and
    makes a wait set for them; all that takes longer than the wait itself. What is destroyed
    while it is in this list goes when the list is closed.

    Of the parts of a `PartedWaitable` those are waited for that await something: most service
    clients of a node await nothing at a given moment, and the middleware looks at each one.
    """

    def __init__(self, nodes: Sequence[Node], own: Sequence[Any], context: Context) -> None:
        """Gather the entities of the nodes.

        :param own: guard conditions of the executor, which end a wait and have no callback
        """
        members = [
            Member(_kind(e, kind), e, n) for n in nodes for kind, es in _kinds(n) for e in es
        ]
        self._nodes = list(nodes)
        self._members = frozenset(members)
        self._gathered = [(live, list(live)) for n in nodes for live in _lists(n)]
        self._groups = {member.entity.callback_group: member.entity for member in members}
        self._waitables = [member for member in members if member.kind == WAITABLE]
        self._guards = [member.entity for member in members if member.kind == GUARD]
        self._simple: dict[int, Member] = {}
        self._parted: dict[int, tuple[Member, Part]] = {}
        self._adds: list[tuple[Any, Callable[[], Any]]] = []
        self._part_adds: list[tuple[Any, Sized, Callable[[], Any]]] = []
        self._held: list[Any] = []
        self._waits = threading.RLock()
        self._context: Any = context.handle
        self._set = _wait_set(members, len(own), self._context)
        for member in members:
            self._take_in(member)
        for guard in own:
            self._hold(None, guard.handle, partial(self._set.add_guard_condition, guard.handle))

    def is_of(self, nodes: Sequence[Node]) -> bool:
        """Tell whether the nodes still have these entities, and no others."""
        return self._nodes == nodes and all(live == then for live, then in self._gathered)

    def has(self, entity: Member) -> bool:
        """Tell whether the nodes had this entity when they were looked at."""
        return entity in self._members

    def wait(self, timeout_ns: int) -> list[Member]:
        """Wait until something is ready, and return that in the order in which it is to run.

        :param timeout_ns: for ever if negative
        """
        busy = {group for group, entity in self._groups.items() if not group.can_execute(entity)}
        for guard in self._guards:
            if guard._executor_triggered:  # noqa: SLF001
                guard.trigger()  # an earlier wait has taken this away, and it did not run
        with self._waits, self._context:
            self._set.clear_entities()
            for group, add in self._adds:
                if group not in busy:
                    add()
            for group, awaited, add in self._part_adds:
                if awaited and group not in busy:
                    add()
            self._set.wait(timeout_ns)
            return self._ready(busy)

    def close(self) -> None:
        """Let go of the entities, after the wait of another thread if there is one."""
        with self._waits:
            for handle in self._held:
                handle.__exit__(None, None, None)
            self._held.clear()
            self._adds.clear()
            self._part_adds.clear()

    def _take_in(self, member: Member) -> None:
        entity, group = member.entity, member.entity.callback_group
        if member.kind == WAITABLE:
            self._hold(group, entity, partial(entity.add_to_wait_set, self._set))
        elif member.kind == PARTED:
            for part in entity.parts:
                self._parted[part.handle.pointer] = member, part
                if self._holds(part.handle):
                    add = self._adder(CLIENT, part.handle)
                    self._part_adds.append((group, part.awaited, add))
        else:
            self._simple[entity.handle.pointer] = member
            self._hold(group, entity.handle, self._adder(member.kind, entity.handle))

    def _adder(self, kind: str, handle: Any) -> Callable[[], Any]:
        return partial(getattr(self._set, f'add_{kind}'), handle)

    def _hold(self, group: Any, handle: Any, add: Callable[[], Any]) -> None:
        """Keep something from being destroyed, and remember how it is put into the wait set."""
        if self._holds(handle):
            self._adds.append((group, add))

    def _holds(self, handle: Any) -> bool:
        """Keep something from being destroyed; tell whether it was not before."""
        try:
            handle.__enter__()
        except _rclpy.InvalidHandle:
            return False  # destroyed, and not forgotten yet
        self._held.append(handle)
        return True

    def _ready(self, busy: set[Any]) -> list[Member]:
        parted: dict[Member, list[Part]] = {}
        simple: list[Member] = []
        for kind in (TIMER, SUBSCRIPTION, GUARD, CLIENT, SERVICE):
            for pointer in self._set.get_ready_entities(kind):
                if pointer in self._simple:
                    member = self._simple[pointer]
                    if kind == GUARD:
                        member.entity._executor_triggered = True  # noqa: SLF001
                    simple.append(member)
                elif pointer in self._parted:
                    member, part = self._parted[pointer]
                    parted.setdefault(member, []).append(part)
        for member, parts in parted.items():
            member.entity.note_ready(parts)
        others = [
            waitable
            for waitable in self._waitables
            if waitable.entity.callback_group not in busy and waitable.entity.is_ready(self._set)
        ]
        return [*parted, *others, *simple]


def _lists(node: Node) -> Sequence[list[Any]]:
    """Return where rclpy keeps the entities of a node: to gather them each time takes longer."""
    return [vars(node)[name] for name in LISTS]


def _kinds(node: Node) -> Sequence[tuple[str, Iterator[Any]]]:
    """Return the entities of a node that can become ready, in the order in which they run."""
    return (
        (WAITABLE, node.waitables),
        (TIMER, node.timers),
        (SUBSCRIPTION, node.subscriptions),
        (GUARD, node.guards),
        (CLIENT, node.clients),
        (SERVICE, node.services),
    )


def _kind(entity: Any, kind: str) -> str:
    return PARTED if isinstance(entity, PartedWaitable) else kind


def _wait_set(members: Sequence[Member], guards: int, context: Any) -> Any:
    kinds = Counter(member.kind for member in members)
    count = NumberOfEntities(
        kinds[SUBSCRIPTION], kinds[GUARD] + guards, kinds[TIMER], kinds[CLIENT], kinds[SERVICE]
    )
    for member in members:
        if member.kind in (WAITABLE, PARTED):
            count += member.entity.get_num_entities()
    with context:
        return _rclpy.WaitSet(
            count.num_subscriptions,
            count.num_guard_conditions,
            count.num_timers,
            count.num_clients,
            count.num_services,
            count.num_events,
            context,
        )
