"""From each part of a cell that waits, over what it waits for, to the root cause.

Waits name what they are for (`model.wait`). So the parts of a cell form a graph: a section waits
for the belt, the belt for the turn of another section, that one for a component, which is held.
Several ways may lead on; the one is told that ends where somebody has to do something.
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from bt_orchestrator.model.hold_words import again_words, hold_wait_words, hold_words
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.status import CellStatus, ComponentStatus, TaskStatus
from bt_orchestrator.model.status_words import component_trouble
from bt_orchestrator.model.wait import BELT, GRAVE, INITIALIZATION, Wait, WaitKind

# The waits of each part of a cell, as links from part to part.

CELL = 'cell'
TASK = 'task'
"""Kind of a link to a component that works on a task: nothing but time is needed."""


@dataclass(frozen=True)
class Link:
    """One part waits for another one."""

    part: str
    """cell, belt, initialization, section/N, component/NAME, hold/ID or job/ID."""
    words: str
    kind: str
    """A `WaitKind`, or `task`."""
    to: str = ''
    """The part that it waits for; empty: it waits for no part of the cell."""


Links = Mapping[str, Sequence[Link]]


def links_of(status: CellStatus) -> Links:
    """Return the links of each part; a part without any waits for nothing."""
    return _Reader(status).links()


class _Reader:
    def __init__(self, status: CellStatus) -> None:
        self._status = status
        self._sections = {section.number for section in status.sections}
        self._held = {hold.component: hold for hold in status.holds if hold.component}
        self._at_work = dict(self._in_flight())

    def links(self) -> Links:
        status = self._status
        links = {
            section_part(section.number): tuple(
                self._of(section_part(section.number), section.waits, section.running)
            )
            for section in status.sections
        }
        belt, running = status.belt, [task for job in status.jobs for task in job.running]
        links[BELT] = tuple(self._of(BELT, belt.waits, belt.running))
        links[INITIALIZATION] = tuple(self._of(INITIALIZATION, status.initialization, running))
        for component in status.components:
            part = component_part(component.name)
            links[part] = tuple(self._of_component(part, component))
        for hold in status.holds:
            links[hold_part(hold.id)] = ()
        return links

    def _in_flight(self) -> Iterator[tuple[str, TaskStatus]]:
        status = self._status
        groups = (
            status.belt.running,
            *(section.running for section in status.sections),
            *(job.running for job in status.jobs),
        )
        for tasks in groups:
            yield from ((task.component, task) for task in tasks)

    def _of(
        self, part: str, waits: Iterable[Wait], running: Iterable[TaskStatus]
    ) -> Iterator[Link]:
        for wait in waits:
            ends = tuple(self._ends(part, wait)) or ('',)
            kind = wait.kind.value
            yield from (Link(part, wait.reason, kind, end) for end in ends if end != part)
        for task in running:
            yield Link(part, _runs(task), TASK, component_part(task.component))

    def _ends(self, part: str, wait: Wait) -> Iterable[str]:
        """Return the parts that have to do something before a wait ends."""
        match wait.kind:
            case WaitKind.HOLD | WaitKind.PAUSE:
                return self._holds(wait)
            case WaitKind.BELT:
                return (BELT,)
            case WaitKind.INITIALIZATION:
                return (INITIALIZATION,)
            case WaitKind.COMPONENT | WaitKind.READINESS | WaitKind.OUT_OF_SERVICE:
                return (component_part(wait.name),)
            case WaitKind.CELL_STATE:
                return (CELL,)
            case WaitKind.ITEM:
                return self._bringers() if part == BELT else (BELT,)
        return (section_part(number) for number in wait.sections if number in self._sections)

    def _holds(self, wait: Wait) -> Iterator[str]:
        """Yield the hold of a wait, which is named itself or by its item; or the paused job."""
        for hold in self._status.holds:
            if wait.name in (hold.id, hold.item):
                yield hold_part(hold.id)
                return
        if any(job.id == wait.name for job in self._status.jobs):
            yield f'job/{wait.name}'

    def _bringers(self) -> Iterator[str]:
        """Yield the sections that could put an item onto an empty belt, and wait."""
        for section in self._status.sections:
            kinds = {wait.kind for wait in section.waits}
            if section.running or kinds - {WaitKind.ITEM, WaitKind.BELT}:
                yield section_part(section.number)

    def _of_component(self, part: str, component: ComponentStatus) -> Iterator[Link]:
        """Yield why a component takes no other task; nothing if it is the cause itself."""
        hold, task = self._held.get(component.name), self._at_work.get(component.name)
        if hold is not None:
            yield Link(part, hold_wait_words([hold]), WaitKind.HOLD.value, hold_part(hold.id))
        elif component.out_of_service_since is not None:
            yield Link(part, component_trouble(component), WaitKind.OUT_OF_SERVICE.value)
        elif component_trouble(component):
            yield Link(part, component_trouble(component), WaitKind.READINESS.value)
        elif task is not None:
            yield Link(part, _runs(task), TASK)


def _runs(task: TaskStatus) -> str:
    words = (f'{task.component} works on {task.id}', again_words(task.round, task.attempt))
    return ', '.join(filter(None, words))


def section_part(number: int) -> str:
    """Return the key of a section."""
    return f'section/{number}'


def component_part(name: str) -> str:
    """Return the key of a component."""
    return f'component/{name}'


def hold_part(hold: str) -> str:
    """Return the key of a hold."""
    return f'hold/{hold}'


# From each part of a cell that waits, over what it waits for, to the root cause.


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
    texts = {hold_part(hold.id): f'hold {hold.id}: {hold_words(hold)}' for hold in status.holds}
    return tuple(_chain(part, chosen, texts) for part in waiting if links[part][0].kind != TASK)


def causes(all_chains: Iterable[Chain], state: PackmlState) -> tuple[Cause, ...]:
    """Return the root causes of chains, the gravest first.

    :param state: of the cell
    """
    roots: dict[tuple[str, str], tuple[Root, list[str]]] = {}
    for chain in all_chains:
        _, waiting = roots.setdefault((chain.root.part, chain.root.kind), (chain.root, []))
        waiting.append(chain.part)
    ranked = sorted(roots.values(), key=lambda entry: _rank(entry[0]))
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
    return (link for group in links.values() for link in group)


def _rank(end: Link | Root) -> int:
    return _GRAVE.index(end.kind) if end.kind in _GRAVE else len(_GRAVE)


def _chain(part: str, chosen: Mapping[str, Link], texts: Mapping[str, str]) -> Chain:
    """Return the chain of a part.

    :param texts: more words for some roots than what waits for them has
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
    return Chain(part, tuple(links), Root(end, last.kind, texts.get(end, last.words)))
