"""The state that a drawing shows, read from the status of a cell, task by task."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator, Mapping

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.script import INDEX, Script, SectionList, Task
from bt_orchestrator.model.state import End, Hold, PassedTask
from bt_orchestrator.model.status import (
    CellStatus,
    ItemStatus,
    JobStatus,
    SectionStatus,
    TaskStatus,
)
from bt_orchestrator.model.status_words import script_words
from bt_orchestrator.model.stop_reason import release_command
from bt_orchestrator.model.wait import Wait
from bt_orchestrator.view.drawing.line_state import LineState, Mark, SectionMark, TaskMark
from bt_orchestrator.view.drawing.wording import ENGLISH, Wording


class NotThisLine(OrchestratorError):
    """A status does not fit the drawing."""


def line_state(
    status: CellStatus, script: Script, cell: Cell, wording: Wording = ENGLISH
) -> LineState:
    """Read what a drawing of a script shows.

    :raises NotThisLine: the status is of another cell
    """
    if status.cell != cell.name:
        raise NotThisLine(
            f'the status is of cell {status.cell}, not of {cell.name}; give the files of one cell'
        )
    return _Reader(status, script, wording).state()


class _Reader:
    def __init__(self, status: CellStatus, script: Script, wording: Wording) -> None:
        self._status = status
        self._script = script
        self._wording = wording
        self._scripts = {job.id: job.script for job in status.jobs}
        self._held = held_tasks(status.holds)

    def state(self) -> LineState:
        status = self._status
        tasks = dict(self._initialization())
        tasks[INDEX] = self._move()
        for section in status.sections:
            tasks.update(self._cycle(section))
        return LineState(
            headline=self._headline(),
            jobs=tuple(map(self._job, status.jobs)),
            belt_moves=status.belt.moving,
            tasks=tasks,
            sections={section.number: self._section(section) for section in status.sections},
            flags={flag.name: flag.count for flag in status.flags},
        )

    def _headline(self) -> str:
        status, say = self._status, self._wording.say
        belt = say('the belt moves') if status.belt.moving else say('the belt rests')
        words = [self._wording.state(status.state), belt]
        if count := len(status.holds):
            words.append(say('1 hold') if count == 1 else say('{count} holds', count=count))
        words.append(say('after event {seq}', seq=status.seq))
        of_cell = ''.join(
            f'; {self._wording.hold(hold)}: {release_command(hold.id)}'
            for hold in status.holds
            if hold.is_pause
        )
        return f'{", ".join(words)}{of_cell}'

    # --- before the line ----------------------------------------------------------------------

    def _initialization(self) -> Iterator[tuple[str, TaskMark]]:
        """Yield the tasks of the job that is being prepared, or of the last one."""
        jobs = [job for job in self._status.jobs if job.script == self._script.name]
        job = next((job for job in jobs if job.initialization), jobs[-1] if jobs else None)
        if job is not None:
            waits = self._status.initialization
            for task, mark in initialization_marks(
                job, self._script.initialization, waits, self._held, self._wording
            ):
                yield task.id, mark

    def _move(self) -> TaskMark:
        held = self._held.get((None, None, INDEX))
        if held is not None:
            return held_mark(held, self._wording)
        belt = self._status.belt
        if belt.running:
            return TaskMark(Mark.RUNNING)
        return TaskMark(Mark.WAITING, reason=reasons(belt.waits, self._wording))

    # --- the line -----------------------------------------------------------------------------

    def _section(self, section: SectionStatus) -> SectionMark:
        script = self._scripts.get(section.job, '')
        is_other = script != self._script.name
        other = f', {self._wording.say("script {name}", name=script)}' if is_other else ''
        slot = section.slot or ItemStatus('')
        return SectionMark(
            slot=slot.id,
            is_empty_position=not slot.present,
            is_rejected=slot.rejected,
            is_nonconforming=bool(slot.nonconforming),
            works_on=f'{section.item.id}{other}' if section.item else '',
            finished=section.finished.item if section.finished else '',
            waiting=tuple(dict.fromkeys(map(self._wording.wait, section.waits))),
        )

    def _cycle(self, section: SectionStatus) -> Iterator[tuple[str, TaskMark]]:
        """Yield the tasks of a section that works for the script that is drawn."""
        tasks = self._script.sections.get(section.number)
        job = section.job or (section.finished.job if section.finished else '')
        if tasks is not None and self._scripts.get(job) == self._script.name:
            for task, mark in cycle_marks(section, tasks, self._held, self._wording):
                yield task.id, mark

    def _job(self, job: JobStatus) -> str:
        states = map(self._wording.job_state, filter(None, (job.state.value, job.ending)))
        return f'{job.id} ({script_words(job)}): {", ".join(states)}, {self._counts(job)}'

    def _counts(self, job: JobStatus) -> str:
        """Say how far a job is; bad counts only when there are any."""
        say = self._wording.say
        words = [say('{count} of {quantity} packed', count=job.packed, quantity=job.quantity)]
        if job.rejected:
            words.append(say('{count} rejected', count=job.rejected))
        if job.missing:
            words.append(say('{count} missing', count=job.missing))
        if job.nonconforming:
            words.append(say('{count} nonconforming', count=job.nonconforming))
        return ', '.join(words)


# How each task of a script stands, read from the parts of a status.

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
    running = {task.id: _again(task, wording) for task in section.running}
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
    running = {task.id for task in job.running}
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
    failure = wording.failure(hold.reason, hold.message, hold.controller_said, hold.topic_says)
    why = ', '.join(filter(None, (failure, _attempt(hold, say))))
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
    return {
        task.id: TaskMark(_ENDS[task.end], reason=wording.passed(task.reason)) for task in tasks
    }


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
