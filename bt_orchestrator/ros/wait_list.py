"""What an executor waits for, kept from one wait to the next."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, NamedTuple

from rclpy.context import Context
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.waitable import NumberOfEntities

WAITABLE = 'waitable'
"""Several entities that are asked together, such as an action client."""
GUARD = 'guard_condition'


class Member(NamedTuple):
    """An entity of a node."""

    kind: str
    """As rclpy's wait set calls it, or WAITABLE."""
    entity: Any
    node: Node

    def may_run(self) -> bool:
        """Tell whether it is to run now; a timer may have been cancelled since it was ready."""
        if self.kind == 'timer' and not self.entity.handle.is_timer_ready():
            return False
        return bool(self.entity.callback_group.can_execute(self.entity))


class WaitList:
    """The entities of some nodes, and a wait set that holds all of them.

    rclpy gathers the entities anew for each wait, asks each whether it may run, and makes a wait
    set for them; all that takes longer than the wait itself.
    """

    def __init__(self, nodes: Sequence[Node], own: Sequence[Any], context: Context) -> None:
        """Gather the entities of the nodes.

        :param own: guard conditions of the executor, which end a wait and have no callback
        """
        members = [
            Member(kind, entity, node)
            for node in nodes
            for kind, entities in _kinds(node)
            for entity in entities
        ]
        self._entities = [one.entity for one in members]
        self._groups = {one.entity.callback_group: one.entity for one in members}
        self._waitables = [one for one in members if one.kind == WAITABLE]
        self._others = {one.entity.handle.pointer: one for one in members if one.kind != WAITABLE}
        self._guards = [one.entity for one in members if one.kind == GUARD]
        self._context: Any = context.handle
        self._set = _wait_set(members, len(own), self._context)
        self._parts = [_Part(one.kind, one.entity, self._set) for one in members]
        self._parts += [_Part(GUARD, guard, self._set) for guard in own]

    def is_of(self, nodes: Sequence[Node]) -> bool:
        """Tell whether the nodes still have these entities, and no others."""
        return self._entities == [
            entity for node in nodes for _, entities in _kinds(node) for entity in entities
        ]

    def wait(self, timeout_ns: int) -> list[Member]:
        """Wait until something is ready, and return that in the order in which it is to run.

        :param timeout_ns: for ever if negative
        """
        busy = {group for group, one in self._groups.items() if not group.can_execute(one)}
        for guard in self._guards:
            if guard._executor_triggered:  # noqa: SLF001
                guard.trigger()  # an earlier wait has taken this away, and it did not run
        with self._context:
            in_use: list[Any] = []
            try:
                self._fill(busy, in_use)
                self._set.wait(timeout_ns)
                return list(self._ready(busy))
            finally:
                for handle in in_use:
                    handle.__exit__(None, None, None)

    def _fill(self, busy: set[Any], in_use: list[Any]) -> None:
        """Put into the wait set what may run, and keep it from being destroyed meanwhile."""
        self._set.clear_entities()
        for part in self._parts:
            if part.group not in busy:
                try:
                    part.handle.__enter__()
                except _rclpy.InvalidHandle:
                    continue  # destroyed, and not forgotten yet
                in_use.append(part.handle)
                part.add()

    def _ready(self, busy: set[Any]) -> Iterator[Member]:
        for one in self._waitables:
            if one.entity.callback_group not in busy and one.entity.is_ready(self._set):
                yield one
        for kind in ('timer', 'subscription', GUARD, 'client', 'service'):
            for pointer in self._set.get_ready_entities(kind):
                if pointer in self._others:  # the parts of waitables are not
                    one = self._others[pointer]
                    if kind == GUARD:
                        one.entity._executor_triggered = True  # noqa: SLF001
                    yield one


class _Part:
    """How one entity is put into a wait set."""

    __slots__ = ('add', 'group', 'handle')

    def __init__(self, kind: str, entity: Any, wait_set: Any) -> None:
        self.group = entity.callback_group
        self.handle: Any = entity if kind == WAITABLE else entity.handle
        self.add: Callable[[], Any] = (
            partial(entity.add_to_wait_set, wait_set)
            if kind == WAITABLE
            else partial(getattr(wait_set, f'add_{kind}'), entity.handle)
        )


def _kinds(node: Node) -> Sequence[tuple[str, Iterator[Any]]]:
    """Return the entities of a node that can become ready, in the order in which they run."""
    return (
        (WAITABLE, node.waitables),
        ('timer', node.timers),
        ('subscription', node.subscriptions),
        (GUARD, node.guards),
        ('client', node.clients),
        ('service', node.services),
    )


def _wait_set(members: Sequence[Member], guards: int, context: Any) -> Any:
    kinds = Counter(one.kind for one in members)
    count = NumberOfEntities(
        kinds['subscription'],
        kinds[GUARD] + guards,
        kinds['timer'],
        kinds['client'],
        kinds['service'],
    )
    for one in members:
        if one.kind == WAITABLE:
            count += one.entity.get_num_entities()
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
