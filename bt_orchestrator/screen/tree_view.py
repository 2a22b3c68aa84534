"""The view of a behaviour tree: a line for each behaviour, and fewer where there is no room."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Protocol, SupportsBytes, SupportsIndex

from bt_orchestrator.screen.fit import stay
from bt_orchestrator.screen.words import one_line

DECORATOR = 6
"""What a snapshot calls a decorator (py_trees_ros_interfaces/msg/Behaviour.DECORATOR)."""


class Status(IntEnum):
    """What a behaviour came to in its last tick; INVALID: it was not ticked."""

    INVALID = 1
    RUNNING = 2
    SUCCESS = 3
    FAILURE = 4

    @property
    def word(self) -> str:
        """The status for a person."""
        return self.name.lower()


WEIGHTS = {Status.RUNNING: 1, Status.FAILURE: 1, Status.SUCCESS: 2, Status.INVALID: 3}


@dataclass(frozen=True)
class Branch:
    """A behaviour with what is below it."""

    name: str
    status: Status
    words: str
    is_decorator: bool
    children: tuple[Branch, ...]

    @property
    def weight(self) -> int:
        """How much it matters; what works or waits itself comes first."""
        works = any(child.status is Status.RUNNING for child in self.children)
        return 0 if self.status is Status.RUNNING and not works else WEIGHTS[self.status]


@dataclass(frozen=True)
class Twig:
    """One line of the picture of a tree."""

    depth: int
    branch: Branch


class Id(Protocol):
    """Names a behaviour (unique_identifier_msgs/msg/UUID)."""

    @property
    def uuid(self) -> Iterable[SupportsIndex] | SupportsBytes:
        """Its bytes."""


class Behaviour(Protocol):
    """A behaviour of a snapshot (py_trees_ros_interfaces/msg/Behaviour)."""

    @property
    def own_id(self) -> Id:
        """What names it."""

    @property
    def parent_id(self) -> Id:
        """What names the one above it; of the root something unknown."""

    @property
    def child_ids(self) -> Sequence[Id]:
        """What names those below it."""

    @property
    def name(self) -> str:
        """What it is called."""

    @property
    def type(self) -> int:
        """What kind it is, for instance DECORATOR."""

    @property
    def status(self) -> int:
        """What it came to."""

    @property
    def message(self) -> str:
        """Its words."""


def tree_of(behaviours: Sequence[Behaviour]) -> Branch | None:
    """Return the tree of a snapshot."""
    by_id = {bytes(behaviour.own_id.uuid): behaviour for behaviour in behaviours}
    parents = (bytes(behaviour.parent_id.uuid) for behaviour in behaviours)
    for behaviour, parent in zip(behaviours, parents, strict=True):
        if parent not in by_id:
            return _branch(behaviour, by_id)
    return None


def _branch(behaviour: Behaviour, by_id: Mapping[bytes, Behaviour]) -> Branch:
    children = (by_id[bytes(child.uuid)] for child in behaviour.child_ids)
    return Branch(
        name=one_line(behaviour.name),
        status=Status(behaviour.status),
        words=one_line(behaviour.message),
        is_decorator=behaviour.type == DECORATOR,
        children=tuple(_branch(child, by_id) for child in children),
    )


def paths(branch: Branch, above: str = '') -> Iterator[tuple[str, Branch]]:
    """Yield every behaviour with its path, the root first."""
    path = f'{above}/{branch.name}'
    yield path, branch
    for child in branch.children:
        yield from paths(child, path)


def twigs(root: Branch, room: int) -> tuple[list[Twig], int]:
    """Return the lines of a tree that find room, and how many behaviours are not shown.

    What does not run is folded first, then what only wraps something that speaks for itself, and
    then what matters least goes.
    """
    lines = list(_all(root, 0))
    total = len(lines)
    for shown in (_live, _essential):
        if len(lines) > room:
            lines = list(shown(root, 0))
    places = stay([twig.branch.weight for twig in lines], room)
    return [lines[place] for place in places], total - len(places)


def _all(branch: Branch, depth: int) -> Iterator[Twig]:
    yield Twig(depth, branch)
    for child in branch.children:
        yield from _all(child, depth + 1)


def _live(branch: Branch, depth: int) -> Iterator[Twig]:
    """Yield what runs with its children, and of all else only the top."""
    yield Twig(depth, branch)
    if branch.status is Status.RUNNING:
        for child in branch.children:
            yield from _live(child, depth + 1)


def _essential(branch: Branch, depth: int) -> Iterator[Twig]:
    """Yield what runs or failed, without decorators whose child says it."""
    ticked = [child for child in branch.children if child.status is not Status.INVALID]
    if branch.is_decorator and ticked:
        yield from _essential(ticked[0], depth)
        return
    yield Twig(depth, branch)
    if branch.status is Status.RUNNING:
        for child in ticked:
            if child.status is not Status.SUCCESS:
                yield from _essential(child, depth + 1)
