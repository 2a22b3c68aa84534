"""From each part of a cell that waits, over what it waits for, to the root cause.

Waits name what they are for (`model.wait`). So the parts of a cell form a graph: a section waits
for the belt, the belt for the turn of another section, that one for a component, which is held.
Several ways may lead on; the one is told that ends where somebody has to do something.
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from bt_orchestrator.model.hold_words import hold_words
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.model.wait import GRAVE, WaitKind
from bt_orchestrator.view.report.wait_links import TASK, Link, hold_part, links_of


@dataclass(frozen=True)
class Root:
    """Where a chain of waits ends."""

    part: str
    """As in `Link`."""
    kind: str
    words: str


@dataclass(frozen=True)
class Chain:
    """From a part that waits to the root cause."""

    part: str
    links: tuple[Link, ...]
    """Each begins where the one before leads."""
    root: Root


@dataclass(frozen=True)
class Cause:
    """A root cause with everything that waits for it."""

    root: Root
    is_ordinary: bool
    """Nothing is wrong: only time is needed, an order, or a command to a cell that is at rest."""
    waiting: tuple[str, ...]
    """Parts whose chains end here."""


_GRAVE = (*(kind.value for kind in GRAVE), TASK)
"""Kinds of root causes, the gravest first; all others come after these."""


_TROUBLE = (PackmlState.ABORTING, PackmlState.ABORTED)
"""States that are no rest."""


def chains(status: CellStatus) -> tuple[Chain, ...]:
    """Return the chain of each section, the belt and initialization, if they wait."""
    links = links_of(status)
    chosen = _chosen(links)
    waiting = [part for part in links if links[part] and _may_wait(part)]
    said = {hold_part(hold.id): f'hold {hold.id}: {hold_words(hold)}' for hold in status.holds}
    return tuple(_chain(part, chosen, said) for part in waiting if links[part][0].kind != TASK)


def causes(found: Iterable[Chain], state: PackmlState) -> tuple[Cause, ...]:
    """Return the root causes of chains, the gravest first.

    :param state: of the cell
    """
    roots: dict[tuple[str, str], tuple[Root, list[str]]] = {}
    for chain in found:
        _, waiting = roots.setdefault((chain.root.part, chain.root.kind), (chain.root, []))
        waiting.append(chain.part)
    ranked = sorted(roots.values(), key=lambda one: _rank(one[0]))
    return tuple(Cause(root, _is_ordinary(root, state), tuple(parts)) for root, parts in ranked)


def _is_ordinary(root: Root, state: PackmlState) -> bool:
    if root.kind == WaitKind.CELL_STATE.value:
        return state not in _TROUBLE
    return _rank(root) >= _GRAVE.index(TASK)


def _may_wait(part: str) -> bool:
    return not part.startswith(('component/', 'hold/', 'job/'))


def _chosen(links: Mapping[str, Sequence[Link]]) -> Mapping[str, Link]:
    """Return for each part the link that leads to the gravest cause, by the shortest way."""
    to: dict[str, list[Link]] = defaultdict(list)
    ends: list[Link] = []
    for link in _each(links):
        to[link.to].append(link)
        if not links.get(link.to):
            ends.append(link)
    chosen: dict[str, Link] = {}
    for end in sorted(ends, key=_rank):
        pending = deque([end])
        while pending:
            link = pending.popleft()
            if link.part not in chosen:
                chosen[link.part] = link
                pending.extend(to[link.part])
    for link in _each(links):  # what waits in a circle has no end
        chosen.setdefault(link.part, link)
    return chosen


def _each(links: Mapping[str, Iterable[Link]]) -> Iterator[Link]:
    return (link for found in links.values() for link in found)


def _rank(end: Link | Root) -> int:
    return _GRAVE.index(end.kind) if end.kind in _GRAVE else len(_GRAVE)


def _chain(part: str, chosen: Mapping[str, Link], said: Mapping[str, str]) -> Chain:
    """Return the chain of a part.

    :param said: more words for some roots than what waits for them has
    """
    links: list[Link] = []
    seen: set[str] = set()
    here = part
    while here in chosen and here not in seen:
        seen.add(here)
        if not links or chosen[here].words != links[-1].words:
            links.append(chosen[here])
        here = chosen[here].to
    last = links[-1]
    end = last.to or last.part
    return Chain(part, tuple(links), Root(end, last.kind, said.get(end, last.words)))
