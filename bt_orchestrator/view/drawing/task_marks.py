"""How each task of a script stands, read from the parts of a status."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator, Mapping

from bt_orchestrator.model.script import SectionList, Task
from bt_orchestrator.model.state import End, Hold, PassedTask
from bt_orchestrator.model.status import JobStatus, SectionStatus, TaskStatus
from bt_orchestrator.model.wait import Wait
from bt_orchestrator.view.drawing.line_state import Mark, TaskMark
from bt_orchestrator.view.drawing.wording import ENGLISH, Wording

HeldTasks = Mapping[tuple[int | None, str | None, str | None], Hold]
"""Holds by section, item (or job, or neither), and task."""


def held_tasks(holds: Iterable[Hold]) -> HeldTasks:
    """Return holds by what they hold."""
    return {(hold.section, hold.item or hold.job, hold.task): hold for hold in holds}


def cycle_marks(
    section: SectionStatus, tasks: SectionList, held: HeldTasks, wording: Wording = ENGLISH
) -> Iterator[tuple[Task, TaskMark]]:
    """Yield the tasks of a section's list with how each stands.

    Without a cycle they stand as the cycle left them that the section finished in this beat.
    """
    if section.item is None:
        left = _passed(section.finished.passed, wording) if section.finished else {}
        yield from ((task, left.get(task.id, NEW)) for task in tasks.tasks)
        return
    passed = _passed(section.passed, wording)
    due = set(_due(tasks, passed))
    running = {one.id: _again(one, wording) for one in section.running}
    for task in tasks.tasks:
        hold = held.get((section.number, section.item.id, task.id))
        if hold is not None:
            yield task, held_mark(hold, wording)
        elif task.id in running:
            words = running[task.id]
            yield task, TaskMark(Mark.RUNNING, f'({words})' if words else '')
        else:
            yield task, passed.get(task.id) or _at_rest(task.id, section, due, wording)


def initialization_marks(
    job: JobStatus,
    tasks: Iterable[Task],
    waits: Iterable[Wait],
    held: HeldTasks,
    wording: Wording = ENGLISH,
) -> Iterator[tuple[Task, TaskMark]]:
    """Yield the initialization tasks of a job with how each stands.

    :param waits: why initialization does not go on
    """
    passed = _passed(job.passed, wording)
    running = {one.id for one in job.running}
    for task in tasks:
        hold = held.get((None, job.id, task.id))
        if task.id not in job.initialization:
            yield task, passed.get(task.id, TaskMark(Mark.DONE))
        elif hold is not None:
            yield task, held_mark(hold, wording)
        elif task.id in running:
            yield task, TaskMark(Mark.RUNNING)
        else:
            yield task, TaskMark(Mark.WAITING, reason=reasons(waits, wording))


def held_mark(hold: Hold, wording: Wording = ENGLISH) -> TaskMark:
    """Return the mark of a held task, with the answers that are possible."""
    say = wording.say
    answers = ' | '.join(map(wording.answer, hold.answers))
    said = wording.failure(hold.reason, hold.message, hold.controller_said, hold.topic_says)
    why = ', '.join(filter(None, (said, _attempt(hold, say))))
    return TaskMark(
        Mark.HELD,
        say('(hold {hold})', hold=hold.id),
        '; '.join(
            filter(
                None,
                (
                    say('{why}; answer with {answers}', why=why, answers=answers),
                    wording.message(hold.answers_why),
                ),
            )
        ),
    )


def _attempt(hold: Hold, say: Callable[..., str]) -> str:
    """Say which attempt failed; one that an operator added is beyond those allowed."""
    number, among = hold.attempt, hold.attempts
    if not number:
        return ''
    if number > among:
        return say('attempt {number}', number=number)
    return say('attempt {number} of {among}', number=number, among=among)


def _again(task: TaskStatus, wording: Wording) -> str:
    """Say which round of a repeat and which attempt it is; empty: the first of both."""
    say = wording.say
    words = [say('round {number}', number=task.round + 1)] if task.round else []
    if task.attempt > 1:
        words.append(say('attempt {number}', number=task.attempt))
    return ', '.join(words)


def reasons(waits: Iterable[Wait], wording: Wording = ENGLISH) -> str:
    """Return what something waits for as one text, each sentence once."""
    return '; '.join(dict.fromkeys(map(wording.wait, waits)))


def _passed(tasks: Iterable[PassedTask], wording: Wording) -> dict[str, TaskMark]:
    """Return how each task stands that was passed."""
    return {one.id: TaskMark(_ENDS[one.end], reason=wording.passed(one.reason)) for one in tasks}


NEW = TaskMark(Mark.NEW)

_ENDS = {
    End.DONE: Mark.DONE,
    End.MARKED_DONE: Mark.MARKED_DONE,
    End.SKIPPED: Mark.SKIPPED,
    End.CONTINUED: Mark.CONTINUED,
    End.REJECTED: Mark.REJECTED,
    End.ABORTED: Mark.ABORTED,
}


def _at_rest(task: str, section: SectionStatus, due: set[str], wording: Wording) -> TaskMark:
    if task in section.failed:
        return TaskMark(Mark.FAILED, reason=reasons(section.waits, wording))
    if task in due:
        return TaskMark(Mark.WAITING, reason=reasons(section.waits, wording))
    return NEW


def _due(tasks: SectionList, done: Container[str]) -> Iterator[str]:
    """Yield the next task of each track of the step that the cycle has come to."""
    for step in tasks.steps:
        left = [[task.id for task in track if task.id not in done] for track in step.tracks]
        if any(left):
            yield from (track[0] for track in left if track)
            return
