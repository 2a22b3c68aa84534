"""From behaviours to messages, at a small cost for each snapshot.

What a behaviour is does not change, so its message is built once and kept; a snapshot sets what
has changed in it.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any
from uuid import UUID

from py_trees.behaviour import Behaviour
from py_trees.common import BlackBoxLevel, Status
from py_trees.composites import Composite, Parallel, Selector, Sequence
from py_trees.decorators import Decorator
from py_trees_ros_interfaces.msg import Behaviour as BehaviourMessage
from py_trees_ros_interfaces.msg import KeyValue
from unique_identifier_msgs import msg as unique_identifier

_STATUS = {
    Status.INVALID: BehaviourMessage.INVALID,
    Status.RUNNING: BehaviourMessage.RUNNING,
    Status.SUCCESS: BehaviourMessage.SUCCESS,
    Status.FAILURE: BehaviourMessage.FAILURE,
}

_LEVEL = {
    BlackBoxLevel.DETAIL: BehaviourMessage.BLACKBOX_LEVEL_DETAIL,
    BlackBoxLevel.COMPONENT: BehaviourMessage.BLACKBOX_LEVEL_COMPONENT,
    BlackBoxLevel.BIG_PICTURE: BehaviourMessage.BLACKBOX_LEVEL_BIG_PICTURE,
    BlackBoxLevel.NOT_A_BLACKBOX: BehaviourMessage.BLACKBOX_LEVEL_NOT_A_BLACKBOX,
}

_ACCESS = (
    ('read', BehaviourMessage.BLACKBOARD_ACCESS_READ),
    ('write', BehaviourMessage.BLACKBOARD_ACCESS_WRITE),
    ('exclusive', BehaviourMessage.BLACKBOARD_ACCESS_EXCLUSIVE_WRITE),
)

_ZERO = unique_identifier.UUID()


class TreeMessages:
    """The messages of a tree, in the state that it had at the last `refresh`.

    :ivar version: another number whenever a status or the tree itself has changed
    """

    def __init__(self) -> None:
        self.version = 0
        self._entries: dict[UUID, _Entry] = {}

    def refresh(self, root: Behaviour) -> None:
        """Look at the tree; not to be called while it is ticked."""
        before, self._entries = self._entries, {}
        self._changed = False
        self._visit(root, before)
        if self._changed or len(before) != len(self._entries):
            self.version += 1

    @property
    def messages(self) -> list[Any]:
        """One message a behaviour, parents first. Valid until the next refresh."""
        return [entry.message for entry in self._entries.values()]

    @property
    def visited_keys(self) -> set[str]:
        """Blackboard keys of the behaviours that the last tick went through."""
        return {key for e in self._entries.values() if e.message.is_active for key in e.keys}

    def _visit(self, behaviour: Behaviour, before: dict[UUID, _Entry]) -> Behaviour | None:
        """Refresh a subtree and return its tip."""
        entry = before.get(behaviour.id)
        if entry is None or not entry.fits(behaviour):
            entry = _Entry(behaviour)
            self._changed = True
        self._entries[behaviour.id] = entry
        tips = {child.id: self._visit(child, before) for child in behaviour.children}
        current = _current_child(behaviour)
        tip = _tip(behaviour, current, tips)
        self._changed |= entry.update(behaviour, current, tip)
        return tip


class _Entry:
    """The message of one behaviour."""

    def __init__(self, behaviour: Behaviour) -> None:
        self._parent = behaviour.parent
        self._children = list(behaviour.children)
        self._status: Status | None = None
        self._text = ''
        self._current: Behaviour | None = None
        self._tip: Behaviour | None = None
        access = list(_access(behaviour))
        self.keys = {key for key, _ in access}
        self.message = BehaviourMessage(
            name=behaviour.name,
            class_name=f'{type(behaviour).__module__}.{type(behaviour).__name__}',
            own_id=_uuid(behaviour),
            parent_id=_uuid(behaviour.parent),
            child_ids=[_uuid(child) for child in behaviour.children],
            type=_type(behaviour),
            additional_detail=_detail(behaviour),
            blackbox_level=_LEVEL[behaviour.blackbox_level],
            blackboard_access=[KeyValue(key=key, value=value) for key, value in access],
        )

    def fits(self, behaviour: Behaviour) -> bool:
        """Tell whether the behaviour is where it was, with the children it had."""
        return behaviour.parent is self._parent and behaviour.children == self._children

    def update(
        self, behaviour: Behaviour, current: Behaviour | None, tip: Behaviour | None
    ) -> bool:
        """Set what is different; tell whether the status was."""
        message = self.message
        # A branch that is not ticked keeps the words of its last tick.
        active = behaviour.status is not Status.INVALID
        text = str(behaviour.feedback_message) if active else ''
        if text != self._text:
            self._text = message.message = text
        if current is not self._current:
            self._current = current
            message.current_child_id = _uuid(current)
        tip = None if tip is behaviour else tip
        if tip is not self._tip:
            self._tip = tip
            message.tip_id = _uuid(tip)
        if behaviour.status is self._status:
            return False
        self._status = behaviour.status
        message.status = _STATUS[behaviour.status]
        message.is_active = active
        return True


def _uuid(behaviour: Behaviour | None) -> Any:
    return _ZERO if behaviour is None else unique_identifier.UUID(uuid=list(behaviour.id.bytes))


def _type(behaviour: Behaviour) -> int:
    for kind, value in (
        (Sequence, BehaviourMessage.SEQUENCE),
        (Selector, BehaviourMessage.SELECTOR),
        (Parallel, BehaviourMessage.PARALLEL),
        (Decorator, BehaviourMessage.DECORATOR),
    ):
        if isinstance(behaviour, kind):
            return int(value)
    return int(BehaviourMessage.BEHAVIOUR)


def _detail(behaviour: Behaviour) -> str:
    if isinstance(behaviour, Parallel):
        return type(behaviour.policy).__name__.replace('Success', '')
    return 'WithMemory' if getattr(behaviour, 'memory', False) else ''


def _access(behaviour: Behaviour) -> Iterator[tuple[str, str]]:
    for client in behaviour.blackboards:
        for attribute, value in _ACCESS:
            for key in sorted(getattr(client, attribute)):
                yield str(key), value


def _current_child(behaviour: Behaviour) -> Behaviour | None:
    """Return a composite's current child, which a composite without children may not tell."""
    if isinstance(behaviour, Composite) and behaviour.children:
        return behaviour.current_child
    return None


def _tip(
    behaviour: Behaviour, current: Behaviour | None, tips: dict[UUID, Behaviour | None]
) -> Behaviour | None:
    """Return what `behaviour.tip()` would, from the tips of its children."""
    if current is not None:
        return tips.get(current.id)
    if isinstance(behaviour, Decorator) and behaviour.decorated.status is not Status.INVALID:
        return tips.get(behaviour.decorated.id)
    return behaviour if behaviour.status is not Status.INVALID else None
