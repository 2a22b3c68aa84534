"""The view of a behaviour tree: a line for each behaviour, and fewer where there is no room."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from bt_orchestrator.model.branch import Branch, Outcome
from bt_orchestrator.model.texts import one_line
from bt_orchestrator.view.screen.fit import stay

WEIGHTS = {Outcome.RUNNING: 1, Outcome.FAILURE: 1, Outcome.SUCCESS: 2, Outcome.INVALID: 3}


def weight_of(branch: Branch) -> int:
    """Return how much a behaviour matters; what works or waits itself comes first."""
    works = any(child.status is Outcome.RUNNING for child in branch.children)
    return 0 if branch.status is Outcome.RUNNING and not works else WEIGHTS[branch.status]


@dataclass(frozen=True)
class Twig:
    """One line of the picture of a tree."""

    depth: int
    branch: Branch


def printable(branch: Branch) -> Branch:
    """Return a tree whose texts steer no terminal."""
    return replace(
        branch,
        name=one_line(branch.name),
        words=one_line(branch.words),
        children=tuple(map(printable, branch.children)),
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
    places = stay([weight_of(twig.branch) for twig in lines], room)
    return [lines[place] for place in places], total - len(places)


def _all(branch: Branch, depth: int) -> Iterator[Twig]:
    yield Twig(depth, branch)
    for child in branch.children:
        yield from _all(child, depth + 1)


def _live(branch: Branch, depth: int) -> Iterator[Twig]:
    """Yield what runs with its children, and of all else only the top."""
    yield Twig(depth, branch)
    if branch.status is Outcome.RUNNING:
        for child in branch.children:
            yield from _live(child, depth + 1)


def _essential(branch: Branch, depth: int) -> Iterator[Twig]:
    """Yield what runs or failed, without decorators whose child says it."""
    ticked = [child for child in branch.children if child.status is not Outcome.INVALID]
    if branch.is_decorator and ticked:
        yield from _essential(ticked[0], depth)
        return
    yield Twig(depth, branch)
    if branch.status is Outcome.RUNNING:
        for child in ticked:
            if child.status is not Outcome.SUCCESS:
                yield from _essential(child, depth + 1)
