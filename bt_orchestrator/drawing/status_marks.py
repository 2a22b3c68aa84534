"""The state that a drawing shows, read from the status of a cell."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator

from bt_orchestrator.drawing.line_state import LineState, Mark, SectionMark, TaskMark
from bt_orchestrator.errors import OrchestratorError
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.hold_words import attempt_words, hold_name, why_words
from bt_orchestrator.model.pauses import release_command
from bt_orchestrator.model.script import INDEX, Script, SectionList
from bt_orchestrator.model.state import End, Hold
from bt_orchestrator.model.status import (
    CellStatus,
    ItemStatus,
    JobStatus,
    PassedTask,
    SectionStatus,
)
from bt_orchestrator.model.status_words import job_count_words, wait_words
from bt_orchestrator.model.wait import Wait


class NotThisLine(OrchestratorError):
    """A status does not fit the drawing."""


def line_state(status: CellStatus, script: Script, cell: Cell) -> LineState:
    """Read what a drawing of a script shows.

    :raises NotThisLine: the status is of another cell
    """
    if status.cell != cell.name:
        raise NotThisLine(f'the status is of cell {status.cell}, not of {cell.name}')
    return _Reader(status, script).state()


class _Reader:
    def __init__(self, status: CellStatus, script: Script) -> None:
        self._status = status
        self._script = script
        self._scripts = {job.id: job.script for job in status.jobs}
        self._held = {
            (hold.section, hold.item or hold.job, hold.task): hold for hold in status.holds
        }

    def state(self) -> LineState:
        status = self._status
        tasks = dict(self._initialization())
        tasks[INDEX] = self._move()
        for section in status.sections:
            tasks.update(self._cycle(section))
        return LineState(
            headline=self._headline(),
            jobs=tuple(map(_job, status.jobs)),
            belt_moves=status.belt.moving,
            tasks=tasks,
            sections={one.number: self._section(one) for one in status.sections},
            flags={flag.name: flag.count for flag in status.flags},
        )

    def _headline(self) -> str:
        status = self._status
        belt = 'the belt moves' if status.belt.moving else 'the belt rests'
        count = len(status.holds)
        held = f', {count} {"hold" if count == 1 else "holds"}' if count else ''
        of_cell = ''.join(
            f'; {hold_name(hold)}: {release_command(hold.id)}'
            for hold in status.holds
            if hold.is_pause
        )
        return f'{status.state.value}, {belt}{held}, after event {status.seq}{of_cell}'

    # --- before the line ----------------------------------------------------------------------

    def _initialization(self) -> Iterator[tuple[str, TaskMark]]:
        """Yield the tasks of the job that is being prepared, or of the last one."""
        jobs = [job for job in self._status.jobs if job.script == self._script.name]
        job = next((one for one in jobs if one.initialization), jobs[-1] if jobs else None)
        if job is None:
            return
        passed = _passed(job.passed)
        for task in self._script.initialization:
            if task.id in job.initialization:
                yield task.id, self._prepared(task.id, job)
            else:
                yield task.id, passed.get(task.id, TaskMark(Mark.DONE))

    def _prepared(self, task: str, job: JobStatus) -> TaskMark:
        held = self._held.get((None, job.id, task))
        if held is not None:
            return _held(held)
        if any(one.id == task for one in job.running):
            return TaskMark(Mark.RUNNING)
        return TaskMark(Mark.WAITING, reason=_reasons(self._status.initialization))

    def _move(self) -> TaskMark:
        held = self._held.get((None, None, INDEX))
        if held is not None:
            return _held(held)
        belt = self._status.belt
        if belt.running:
            return TaskMark(Mark.RUNNING)
        return TaskMark(Mark.WAITING, reason=_reasons(belt.waits))

    # --- the line -----------------------------------------------------------------------------

    def _section(self, section: SectionStatus) -> SectionMark:
        script = self._scripts.get(section.job, '')
        other = '' if script == self._script.name else f', script {script}'
        slot = section.slot or ItemStatus('')
        return SectionMark(
            slot=slot.id,
            is_empty_position=not slot.present,
            is_rejected=slot.rejected,
            is_nonconforming=bool(slot.nonconforming),
            works_on=f'{section.item.id}{other}' if section.item else '',
            waiting=wait_words(section.waits),
        )

    def _cycle(self, section: SectionStatus) -> Iterator[tuple[str, TaskMark]]:
        """Yield the tasks of a section that works for the script that is drawn."""
        tasks = self._script.sections.get(section.number)
        is_drawn = self._scripts.get(section.job) == self._script.name
        if tasks is None or section.item is None or not is_drawn:
            return
        passed = _passed(section.passed)
        due = set(_due(tasks, passed))
        attempts = {one.id: one.attempt for one in section.running}
        for task in tasks.tasks:
            held = self._held.get((section.number, section.item.id, task.id))
            if held is not None:
                yield task.id, _held(held)
            elif task.id in attempts:
                attempt = f'(attempt {attempts[task.id]})' if attempts[task.id] > 1 else ''
                yield task.id, TaskMark(Mark.RUNNING, attempt)
            else:
                yield task.id, passed.get(task.id) or _at_rest(task.id, section, due)


def _passed(tasks: Iterable[PassedTask]) -> dict[str, TaskMark]:
    """Return how each task stands that was passed."""
    return {one.id: TaskMark(_ENDS[one.end], reason=one.reason) for one in tasks}


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
        return TaskMark(Mark.FAILED, reason=_reasons(section.waits))
    if task in due:
        return TaskMark(Mark.WAITING, reason=_reasons(section.waits))
    return TaskMark(Mark.NEW)


def _reasons(waits: Iterable[Wait]) -> str:
    return '; '.join(wait_words(waits))


def _due(tasks: SectionList, done: Container[str]) -> Iterator[str]:
    """Yield the next task of each track of the step that the cycle has come to."""
    for step in tasks.steps:
        left = [[task.id for task in track if task.id not in done] for track in step.tracks]
        if any(left):
            yield from (track[0] for track in left if track)
            return


def _held(hold: Hold) -> TaskMark:
    answers = ' | '.join(hold.answers)
    words = attempt_words(hold.attempt, hold.attempts)
    attempt = f', {words}' if words else ''
    return TaskMark(
        Mark.HELD,
        f'(hold {hold.id})',
        f'{why_words(hold.reason, hold.message)}{attempt}; answer with {answers}',
    )


def _job(job: JobStatus) -> str:
    return f'{job.id} ({job.script}): {job.state.state}, {job_count_words(job)}'
