"""The state that a drawing shows, read from the status of a cell."""

from __future__ import annotations

from collections.abc import Iterator

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.pauses import release_command
from bt_orchestrator.model.script import INDEX, Script
from bt_orchestrator.model.status import CellStatus, ItemStatus, JobStatus, SectionStatus
from bt_orchestrator.model.status_words import script_words
from bt_orchestrator.view.drawing.line_state import LineState, Mark, SectionMark, TaskMark
from bt_orchestrator.view.drawing.task_marks import (
    cycle_marks,
    held_mark,
    held_tasks,
    initialization_marks,
    reasons,
)
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
            sections={one.number: self._section(one) for one in status.sections},
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
        job = next((one for one in jobs if one.initialization), jobs[-1] if jobs else None)
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
