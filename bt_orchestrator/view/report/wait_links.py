"""The waits of each part of a cell, as links from part to part."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from bt_orchestrator.model.hold_words import again_words, hold_wait_words
from bt_orchestrator.model.status import CellStatus, ComponentStatus, TaskStatus
from bt_orchestrator.model.status_words import component_trouble
from bt_orchestrator.model.wait import BELT, INITIALIZATION, Wait, WaitKind

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
        self._sections = {one.number for one in status.sections}
        self._held = {hold.component: hold for hold in status.holds if hold.component}
        self._at_work = dict(self._in_flight())

    def links(self) -> Links:
        status = self._status
        found = {
            section_part(one.number): tuple(
                self._of(section_part(one.number), one.waits, one.running)
            )
            for one in status.sections
        }
        belt, running = status.belt, [task for job in status.jobs for task in job.running]
        found[BELT] = tuple(self._of(BELT, belt.waits, belt.running))
        found[INITIALIZATION] = tuple(self._of(INITIALIZATION, status.initialization, running))
        for component in status.components:
            part = component_part(component.name)
            found[part] = tuple(self._of_component(part, component))
        for hold in status.holds:
            found[hold_part(hold.id)] = ()
        return found

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
