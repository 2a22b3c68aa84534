"""The entities of nodes, kept from one wait to the next. It knows rclpy's inside."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Sequence, Sized
from functools import partial
from typing import Any, NamedTuple

from rclpy.context import Context
from rclpy.guard_condition import GuardCondition
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.waitable import NumberOfEntities

from bt_orchestrator.ros.executor.lean_parts import LISTS, Part, PartedWaitable

WAITABLE = 'waitable'
"""Several entities that are asked together, such as an action server."""
PARTED = 'parted waitable'
"""Several service clients, with the answers that came for each."""
GUARD = 'guard_condition'
TIMER = 'timer'
SUBSCRIPTION = 'subscription'
CLIENT = 'client'
SERVICE = 'service'

_IN_TURN = (TIMER, SUBSCRIPTION, GUARD, CLIENT, SERVICE)
"""The order in which they run."""

OFTEN = (WAITABLE, PARTED, GUARD, TIMER, SUBSCRIPTION, CLIENT)
SELDOM = (SERVICE,)
FOR_EVER_NS = -1


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

    def __init__(
        self, nodes: Sequence[Node], own: Sequence[Any], context: Context, kinds: Collection[str]
    ) -> None:
        """Gather the entities of the nodes.

        :param own: guard conditions of the executor, which end a wait and have no callback
        :param kinds: which entities
        """
        every = (Member(_kind(e, kind), e, n) for n in nodes for kind, es in _kinds(n) for e in es)
        members = [member for member in every if member.kind in kinds]
        self._nodes = list(nodes)
        self._members = frozenset(members)
        self._gathered = [(live, list(live)) for n in nodes for live in _lists(n)]
        self._groups = {member.entity.callback_group: member.entity for member in members}
        self._waitables = [member for member in members if member.kind == WAITABLE]
        self._guards = [member.entity for member in members if member.kind == GUARD]
        here = {CLIENT if member.kind == PARTED else member.kind for member in members}
        self._kinds = [kind for kind in _IN_TURN if kind in here]
        self._simple: dict[int, Member] = {}
        self._parted: dict[int, tuple[Member, Part]] = {}
        self._adds: list[tuple[Any, Callable[[], Any]]] = []
        self._part_adds: list[tuple[Any, Sized, Callable[[], Any]]] = []
        self._held: list[Any] = []
        self._waits = threading.RLock()
        self._is_closed = False
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

    @property
    def is_empty(self) -> bool:
        """Tell whether there is nothing to wait for."""
        return not self._members

    def busy(self) -> set[Any]:
        """Return the callback groups in which something awaits; to be asked between two turns."""
        return {group for group, entity in self._groups.items() if not group.can_execute(entity)}

    def wait(self, timeout_ns: int, busy: set[Any]) -> list[Member]:
        """Wait until something is ready, and return that in the order in which it is to run.

        :param timeout_ns: for ever if negative
        :param busy: the groups whose entities are not waited for
        :return: nothing also if a guard condition of the executor came, or it was closed
        """
        for guard in self._guards:
            if guard._executor_triggered:  # noqa: SLF001
                guard.trigger()  # an earlier wait has taken this away, and it did not run
        with self._waits, self._context:
            if self._is_closed:
                return []
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
            self._is_closed = True
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
        for kind in self._kinds:
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


# What is seldom ready, and waited for apart.


class SeldomReady:
    """Waits for the services of the nodes in a thread of its own.

    A node has many, people and programs ask one now and then, and the middleware looks at each in
    each wait: without them a wait of the executor takes two thirds.

    States: waiting, and at rest from when it has found something until that has run.
    """

    def __init__(self, wake: Callable[[], None], context: Context) -> None:
        """Begin with nothing to wait for.

        :param wake: called in the other thread when something was found
        """
        self._wake = wake
        self._context = context
        self._guard = GuardCondition(None, None, context)
        self._list: WaitList | None = None
        self._may_wait = threading.Event()
        self._found: Sequence[Member] = ()
        self._is_resting = False
        """Something was taken, and may not have run."""
        self._busy: set[Any] = set()
        self._is_ended = False
        self._thread: threading.Thread | None = None

    def follow(self, nodes: Sequence[Node]) -> None:
        """Wait for what the nodes have now, and for nothing else."""
        self._leave_list()
        self._is_resting = False
        now = WaitList(nodes, [self._guard], self._context, SELDOM)
        if now.is_empty:
            now.close()
            return
        self._list, self._busy = now, now.busy()
        if self._thread is None:
            self._thread = threading.Thread(target=self._serve, daemon=True)
            self._thread.start()
        self._may_wait.set()

    def go_on(self) -> None:
        """Wait on, as all that was taken has run; to be called before each wait of the executor.

        What may not run is left out until it may: something awaits in its group.
        """
        if self._list is None or not (self._is_resting or self._busy):
            return
        before, self._busy = self._busy, self._list.busy()
        if self._is_resting:
            self._is_resting = False
            self._may_wait.set()
        elif self._busy != before:
            self._guard.trigger()  # it waits anew

    def take(self) -> Sequence[Member]:
        """Return what is ready, once."""
        ready, self._found = self._found, ()
        self._is_resting = self._is_resting or bool(ready)
        return ready

    def has(self, entity: Member) -> bool:
        """Tell whether the nodes had this entity when they were looked at."""
        return self._list is not None and self._list.has(entity)

    def close(self) -> None:
        """End the thread, and let go of what it waits for."""
        self._is_ended = True
        self._leave_list()
        self._may_wait.set()
        if self._thread is not None:
            self._thread.join()
        self._guard.destroy()

    def _leave_list(self) -> None:
        left, self._list = self._list, None  # before its wait ends: it is not taken up again
        if left is not None:
            self._guard.trigger()
            left.close()

    def _serve(self) -> None:
        while True:
            self._may_wait.wait()
            self._may_wait.clear()
            if self._is_ended:
                return
            waited = self._list
            ready: Sequence[Member] = ()
            while waited is not None and waited is self._list and not ready:
                # Not asked here: the executor may be in a turn of any group.
                ready = waited.wait(FOR_EVER_NS, self._busy)
            if ready:
                self._found = ready
                self._wake()
