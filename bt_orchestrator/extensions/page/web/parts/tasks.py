"""Tasks and waits as parts: what a script says of a task, how it stands, what it waits for."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from operator import itemgetter

from bt_orchestrator.extensions.page.web.wording import wordings
from bt_orchestrator.model.codec import plain_but
from bt_orchestrator.model.hold_words import held_words
from bt_orchestrator.model.script import Script, SectionList, Task
from bt_orchestrator.model.state import Hold
from bt_orchestrator.model.status import (
    CellDescription,
    CellStatus,
    JobStatus,
    SectionStatus,
    TaskStatus,
)
from bt_orchestrator.model.status_words import task_label
from bt_orchestrator.model.wait import GRAVE, Wait, WaitKind
from bt_orchestrator.view.drawing.line_state import Mark, TaskMark
from bt_orchestrator.view.drawing.status_marks import (
    NEW,
    cycle_marks,
    held_tasks,
    initialization_marks,
)
from bt_orchestrator.view.report.wait_chains import Link, Root, causes, chains

Part = dict[str, object]

_WAITS = (Mark.WAITING, Mark.FAILED)
"""Marks whose reason is what their section waits for."""

_AT_REST: Part = {'round': 0, 'started': None, 'feedback': ''}

LATE = 1.5
"""A task is late after so many times its expected seconds."""


class TaskParts:
    """Makes the parts of tasks of one status."""

    def __init__(
        self, description: CellDescription, holds: Sequence[Hold], now: float = 0.0
    ) -> None:
        """Take what all tasks share.

        :param now: the moment of the status
        """
        self._nominal = {
            component.name: (component.durations_s, component.default_duration_s)
            for component in description.components
        }
        self._holds, self._held, self._now = holds, held_tasks(holds), now

    def of_section(self, section: SectionStatus, tasks: SectionList) -> list[Part]:
        """Return the whole list of a section, in its order."""
        running = {task.id: task for task in section.running}
        item = section.item.id if section.item else None
        held = {
            task: hold
            for (number, subject, task), hold in self._held.items()
            if number == section.number and subject == item
        }
        marks = cycle_marks(section, tasks, self._held)
        places = _places(tasks)
        return [
            self._part(task, mark, place, running.get(task.id), held.get(task.id), section.waits)
            for (task, mark), place in zip(marks, places, strict=True)
        ]

    def of_initialization(
        self, job: JobStatus, script: Script, waits: Iterable[Wait]
    ) -> list[Part]:
        """Return the initialization tasks of a job; before its turn they are all new."""
        tasks = script.initialization
        running, waits = {task.id: task for task in job.running}, tuple(waits)
        if job.position:
            marks: Iterator[tuple[Task, TaskMark]] = ((task, NEW) for task in tasks)
        else:
            marks = initialization_marks(job, tasks, waits, self._held)
        return [
            self._part(
                task,
                mark,
                (0, 0),
                running.get(task.id),
                self._held.get((None, job.id, task.id)),
                waits,
            )
            for task, mark in marks
        ]

    def in_flight(self, running: Iterable[TaskStatus]) -> list[Part]:
        """Return tasks that no script lists: the move of the belt."""
        return [
            self._part(
                Task(task.id, task.name, task.action, task.component),
                TaskMark(Mark.RUNNING),
                (0, 0),
                task,
                None,
            )
            for task in running
        ]

    def _part(
        self,
        task: Task,
        mark: TaskMark,
        place: tuple[int, int],
        running: TaskStatus | None,
        hold: Hold | None,
        waits: Iterable[Wait] = (),
    ) -> Part:
        expected_s = self._expected_s(task, running)
        return {
            'id': task.id,
            'name': task.name,
            'label': task_label(task.id, task.name),
            'component': task.component,
            'step': place[0],
            'track': place[1],
            'mark': mark.mark.name.lower(),
            'reason': held_words(hold) if hold else mark.reason,
            'hold': hold.id if hold else '',
            'waits': wait_parts(waits, self._holds) if mark.mark in _WAITS else [],
            **(
                plain_but(running, 'goal', 'action')
                if running
                else {**_AT_REST, 'attempt': hold.attempt if hold else 0}
            ),
            'expected_s': expected_s,
            'is_late': self._is_late(running, expected_s),
            'requires_conveyor': task.requires_conveyor,
        }

    def _is_late(self, running: TaskStatus | None, expected_s: float | None) -> bool:
        if running is None or not expected_s:
            return False
        return self._now - running.started > LATE * expected_s

    def _expected_s(self, task: Task, running: TaskStatus | None) -> float | None:
        if running is not None and running.expected_s is not None:
            return running.expected_s
        durations_s: Mapping[str, float]
        durations_s, default_s = self._nominal.get(task.component, ({}, None))
        return durations_s.get(task.name, default_s)


def _places(tasks: SectionList) -> Iterator[tuple[int, int]]:
    """Yield step and track of each task, both from 1."""
    for step_number, step in enumerate(tasks.steps, 1):
        for track_number, track in enumerate(step.tracks, 1):
            yield from ((step_number, track_number) for _ in track)


# Waits as parts: as data, and in the words of each language.


def wait_parts(waits: Iterable[Wait], holds: Iterable[Hold]) -> list[dict[str, object]]:
    """Return waits, each sentence once; those of what is not normal go first.

    :param holds: all that there are
    """
    parts = [_wait_part(wait, holds) for wait in {wait.reason: wait for wait in waits}.values()]
    return sorted(parts, key=itemgetter('is_ordinary'))


def _wait_part(wait: Wait, holds: Iterable[Hold]) -> dict[str, object]:
    return {
        **plain_but(wait, 'reason'),
        'words': wait.reason,
        'said': _said(wait, holds),
        'is_ordinary': wait.kind not in GRAVE or wait.kind is WaitKind.CELL_STATE,
    }


def _said(wait: Wait, holds: Iterable[Hold]) -> dict[str, str]:
    """Return what something waits for, in each language of the page."""
    hold = next((hold for hold in holds if wait.name in (hold.id, hold.item)), None)
    task, reason = (task_label(hold.task or '', hold.name), hold.reason) if hold else ('', '')
    return _worded(wait, task, reason)


@lru_cache(maxsize=1024)
def _worded(wait: Wait, task: str, reason: str) -> dict[str, str]:
    return {language: words.wait(wait, task, reason) for language, words in wordings().items()}


def why_part(status: CellStatus) -> dict[str, object]:
    """Return the walk from each part that waits to its cause, and the causes, gravest first."""
    walks = chains(status)
    sentences = _all_said(status)

    def plain(link: Link | Root) -> dict[str, object]:
        return {**vars(link), 'said': sentences.get(link.words)}

    return {
        'chains': [
            {'part': walk.part, 'links': list(map(plain, walk.links)), 'root': plain(walk.root)}
            for walk in walks
        ],
        'causes': [
            {**plain(cause.root), 'is_ordinary': cause.is_ordinary, 'waiting': list(cause.waiting)}
            for cause in causes(walks, status.state)
        ],
    }


def waits_said(status: CellStatus, language: str) -> Mapping[str, str]:
    """Return the sentences of all waits, by those of the node."""
    return {words: sentences[language] for words, sentences in _all_said(status).items()}


def _all_said(status: CellStatus) -> dict[str, dict[str, str]]:
    return {wait.reason: _said(wait, status.holds) for wait in _waits(status)}


def _waits(status: CellStatus) -> Iterator[Wait]:
    yield from (wait for section in status.sections for wait in section.waits)
    yield from (*status.belt.waits, *status.initialization)
