"""How each task of a script stands, read from the parts of a status."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping

from bt_orchestrator.drawing.line_state import Mark, TaskMark
from bt_orchestrator.model.hold_words import again_words, attempt_words, why_words
from bt_orchestrator.model.script import SectionList, Task
from bt_orchestrator.model.state import End, Hold
from bt_orchestrator.model.status import JobStatus, PassedTask, SectionStatus
from bt_orchestrator.model.status_words import wait_words
from bt_orchestrator.model.wait import Wait

HeldTasks = Mapping[tuple[int | None, str | None, str | None], Hold]
"""Holds by section, item (or job, or neither), and task."""


def held_tasks(holds: Iterable[Hold]) -> HeldTasks:
    """Return holds by what they hold."""
    return {(hold.section, hold.item or hold.job, hold.task): hold for hold in holds}


def cycle_marks(
    section: SectionStatus, tasks: SectionList, held: HeldTasks
) -> Iterator[tuple[Task, TaskMark]]:
    """Yield the tasks of a section's list with how each stands; without a cycle they are new."""
    if section.item is None:
        yield from ((task, NEW) for task in tasks.tasks)
        return
    passed = _passed(section.passed)
    due = set(_due(tasks, passed))
    running = {one.id: again_words(one.round, one.attempt) for one in section.running}
    for task in tasks.tasks:
        hold = held.get((section.number, section.item.id, task.id))
        if hold is not None:
            yield task, held_mark(hold)
        elif task.id in running:
            words = running[task.id]
            yield task, TaskMark(Mark.RUNNING, f'({words})' if words else '')
        else:
            yield task, passed.get(task.id) or _at_rest(task.id, section, due)


def initialization_marks(
    job: JobStatus, tasks: Iterable[Task], waits: Iterable[Wait], held: HeldTasks
) -> Iterator[tuple[Task, TaskMark]]:
    """Yield the initialization tasks of a job with how each stands.

    :param waits: why initialization does not go on
    """
    passed = _passed(job.passed)
    running = {one.id for one in job.running}
    for task in tasks:
        hold = held.get((None, job.id, task.id))
        if task.id not in job.initialization:
            yield task, passed.get(task.id, TaskMark(Mark.DONE))
        elif hold is not None:
            yield task, held_mark(hold)
        elif task.id in running:
            yield task, TaskMark(Mark.RUNNING)
        else:
            yield task, TaskMark(Mark.WAITING, reason=reasons(waits))


def held_mark(hold: Hold) -> TaskMark:
    """Return the mark of a held task, with the answers that are possible."""
    answers = ' | '.join(hold.answers)
    words = attempt_words(hold.attempt, hold.attempts)
    attempt = f', {words}' if words else ''
    return TaskMark(
        Mark.HELD,
        f'(hold {hold.id})',
        f'{why_words(hold.reason, hold.message)}{attempt}; answer with {answers}',
    )


def reasons(waits: Iterable[Wait]) -> str:
    """Return what something waits for as one text."""
    return '; '.join(wait_words(waits))


def _passed(tasks: Iterable[PassedTask]) -> dict[str, TaskMark]:
    """Return how each task stands that was passed."""
    return {one.id: TaskMark(_ENDS[one.end], reason=one.reason) for one in tasks}


NEW = TaskMark(Mark.NEW)

_ENDS = {
    End.DONE: Mark.DONE,
    End.MARKED_DONE: Mark.MARKED_DONE,
    End.SKIPPED: Mark.SKIPPED,
    End.CONTINUED: Mark.CONTINUED,
    End.REJECTED: Mark.REJECTED,
    End.ABORTED: Mark.ABORTED,
}


def _at_rest(task: str, section: SectionStatus, due: set[str]) -> TaskMark:
    if task in section.failed:
        return TaskMark(Mark.FAILED, reason=reasons(section.waits))
    if task in due:
        return TaskMark(Mark.WAITING, reason=reasons(section.waits))
    return NEW


def _due(tasks: SectionList, done: Container[str]) -> Iterator[str]:
    """Yield the next task of each track of the step that the cycle has come to."""
    for step in tasks.steps:
        left = [[task.id for task in track if task.id not in done] for track in step.tracks]
        if any(left):
            yield from (track[0] for track in left if track)
            return
