"""From a status of the node (`status --json`) to what a drawing shows of it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from bt_orchestrator.drawing.line_state import LineState, Mark, SectionMark, TaskMark
from bt_orchestrator.errors import OrchestratorError
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.hold_words import attempt_words
from bt_orchestrator.model.pauses import release_command
from bt_orchestrator.model.script import INDEX, Script, SectionList, Task

Plain = Mapping[str, Any]
"""A message as JSON."""


class NotThisLine(OrchestratorError):
    """A status does not fit what is to be drawn."""


def line_state(status: Plain, script: Script, cell: Cell) -> LineState:
    """Read what a drawing of a script shows.

    :param status: the fields of bt_orchestrator_interfaces/msg/Status as plain values
    :raises NotThisLine: it is of another cell, or no status at all
    """
    try:
        if status['cell'] != cell.name:
            raise NotThisLine(f'the status is of cell {status["cell"]}, not of {cell.name}')
        return _Reader(status, script, cell).state()
    except (KeyError, TypeError, AttributeError) as error:
        raise NotThisLine(
            f'this is no status of a tree node (as `status --json` prints it): {error!r}'
        ) from error


class _Reader:
    def __init__(self, status: Plain, script: Script, cell: Cell) -> None:
        self._status = status
        self._script = script
        self._cell = cell
        self._scripts = {job['id']: job['script'] for job in status['jobs']}
        self._held = {
            (hold['section'], hold['item'] or hold['job'], hold['task']): hold
            for hold in status['holds']
        }

    def state(self) -> LineState:
        status = self._status
        tasks = dict(self._initialization())
        tasks[INDEX] = self._move()
        for section in status['sections']:
            tasks.update(self._cycle(section))
        return LineState(
            headline=self._headline(),
            jobs=tuple(map(_job, status['jobs'])),
            belt_moves=status['belt_moving'],
            tasks=tasks,
            sections={one['section']: self._section(one) for one in status['sections']},
            flags={flag['name']: flag['count'] for flag in status['flags']},
        )

    def _headline(self) -> str:
        status = self._status
        belt = 'the belt moves' if status['belt_moving'] else 'the belt rests'
        count = len(status['holds'])
        held = f', {count} {"hold" if count == 1 else "holds"}' if count else ''
        of_cell = ''.join(
            f'; hold {hold["id"]} ({hold["reason"]}): {release_command(hold["id"])}'
            for hold in status['holds']
            if not hold['task'] and not hold['item']
        )
        return f'{status["state"]}, {belt}{held}, after event {status["seq"]}{of_cell}'

    # --- before the line ----------------------------------------------------------------------

    def _initialization(self) -> Iterator[tuple[str, TaskMark]]:
        """Yield the tasks of the job that is being prepared, or of the last one."""
        jobs = [job for job in self._status['jobs'] if job['script'] == self._script.name]
        job = next((one for one in jobs if one['initialization']), jobs[-1] if jobs else None)
        if job is None:
            return
        reasons = tuple(self._status['initialization_waiting'])
        passed = _passed(job['passed'])
        for task in self._script.initialization:
            if task.id in job['initialization']:
                yield task.id, self._prepared(task, job['id'], reasons)
            else:
                yield task.id, passed.get(task.id, TaskMark(Mark.DONE))

    def _prepared(self, task: Task, job: str, reasons: Sequence[str]) -> TaskMark:
        held = self._held.get((0, job, task.id))
        if held is not None:
            return _held(held)
        if self._has(task.component, f'{task.id} of {job}'):
            return TaskMark(Mark.RUNNING)
        return TaskMark(Mark.WAITING, reason='; '.join(reasons))

    def _has(self, component: str, task: str) -> bool:
        components = self._status['components']
        return any(one['name'] == component and one['task'] == task for one in components)

    def _move(self) -> TaskMark:
        held = self._held.get((0, '', INDEX))
        if held is not None:
            return _held(held)
        if self._has(self._cell.conveyor.component.name, INDEX):
            return TaskMark(Mark.RUNNING)
        return TaskMark(Mark.WAITING, reason='; '.join(self._status['belt_waiting']))

    # --- the line -----------------------------------------------------------------------------

    def _section(self, section: Plain) -> SectionMark:
        script = self._scripts.get(section['job'], '')
        other = '' if script == self._script.name else f', script {script}'
        return SectionMark(
            slot=section['slot'],
            is_empty_position=section['slot_empty_position'],
            is_rejected=section['slot_rejected'],
            is_nonconforming=bool(section['slot_nonconforming']),
            works_on=f'{section["item"]}{other}' if section['job'] else '',
            waiting=tuple(section['waiting']),
        )

    def _cycle(self, section: Plain) -> Iterator[tuple[str, TaskMark]]:
        """Yield the tasks of a section that works for the script that is drawn."""
        tasks = self._script.sections.get(section['section'])
        if tasks is None or self._scripts.get(section['job']) != self._script.name:
            return
        due = set(_due(tasks, section['done']))
        running = {one['id']: one['attempt'] for one in section['running']}
        passed = _passed(section['passed'])
        for task in tasks.tasks:
            held = self._held.get((section['section'], section['item'], task.id))
            if held is not None:
                yield task.id, _held(held)
            elif task.id in running:
                attempt = f'(attempt {running[task.id]})' if running[task.id] > 1 else ''
                yield task.id, TaskMark(Mark.RUNNING, attempt)
            else:
                yield task.id, passed.get(task.id) or _at_rest(task.id, section, due)


def _passed(tasks: Iterable[Plain]) -> dict[str, TaskMark]:
    """Return how each task stands that was passed."""
    return {one['id']: TaskMark(_ENDS[one['end']], reason=one['reason']) for one in tasks}


_ENDS = {
    'done': Mark.DONE,
    'marked_done': Mark.MARKED_DONE,
    'skipped': Mark.SKIPPED,
    'continued': Mark.CONTINUED,
    'rejected': Mark.REJECTED,
    'aborted': Mark.ABORTED,
}


def _at_rest(task: str, section: Plain, due: set[str]) -> TaskMark:
    if task in section['failed']:
        return TaskMark(Mark.FAILED, reason='; '.join(section['waiting']))
    if task in due:
        return TaskMark(Mark.WAITING, reason='; '.join(section['waiting']))
    return TaskMark(Mark.NEW)


def _due(tasks: SectionList, done: Sequence[str]) -> Iterator[str]:
    """Yield the next task of each track of the step that the cycle has come to."""
    for step in tasks.steps:
        left = [[task.id for task in track if task.id not in done] for track in step.tracks]
        if any(left):
            yield from (track[0] for track in left if track)
            return


def _held(hold: Plain) -> TaskMark:
    message = f' ({hold["message"]})' if hold['message'] else ''
    answers = ' | '.join(hold['answers'])
    return TaskMark(
        Mark.HELD,
        f'(hold {hold["id"]})',
        f'{hold["reason"]}{message}{_attempt(hold)}; answer with {answers}',
    )


def _attempt(hold: Plain) -> str:
    """Return which attempt failed, where the status knows it."""
    words = attempt_words(hold.get('attempt', 0), hold.get('attempts', 0))
    return f', {words}' if words else ''


def _job(job: Plain) -> str:
    named = ('rejected', 'missing', 'nonconforming')
    bad = [f'{job[name]} {name}' for name in named if job[name]]
    counts = ', '.join([f'{job["packed"]} of {job["quantity"]} packed', *bad])
    return f'{job["id"]} ({job["script"]}): {job["state"]}, {counts}'
