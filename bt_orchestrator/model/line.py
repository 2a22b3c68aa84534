"""The rules of cycles, turns and the belt, as questions to the state (semantics 3, 5.2, 6.1)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from enum import Enum
from typing import NamedTuple

from bt_orchestrator.model.cell import Approval
from bt_orchestrator.model.events import TaskKey
from bt_orchestrator.model.hold_words import hold_wait_words
from bt_orchestrator.model.jobs.initialization import Preparation
from bt_orchestrator.model.script import SectionList, Task
from bt_orchestrator.model.state import CellState, JobState, Phase, SectionState
from bt_orchestrator.model.wait import Wait, WaitKind
from bt_orchestrator.model.words import sentence


class Start(NamedTuple):
    """A cycle that may begin now."""

    job: str
    item: str
    beat: int


def task_list(state: CellState, job: str, section: int) -> SectionList | None:
    """Return what a section does for a job; None: nothing."""
    return state.script(job).sections.get(section)


def stopped_because(state: CellState) -> Wait | None:
    """Say why nothing new begins anywhere: no cycle, no index move (semantics 7.1)."""
    if state.holds:
        kind = WaitKind.PAUSE if state.stops else WaitKind.HOLD
        first, *others = state.holds
        holds = (first, *others) if others else ()
        return Wait(hold_wait_words(state.holds.values()), kind, first, holds=holds)
    if not state.packml.begins:
        mode = state.packml.value
        return Wait(sentence('cell_is', state=mode), WaitKind.CELL_STATE, mode)
    if state.barred:
        return Wait(barred_because(state), WaitKind.CELL_STATE, state.packml.value)
    return None


def barred_because(state: CellState) -> str:
    """Say why nothing starts in a cell that would work: the node ends, or it is not safe (7.9)."""
    if state.shutting_down:
        return sentence('ending')
    return sentence('unsafe', words=state.unsafe)


def waits_for_service(state: CellState, component: str) -> Wait | None:
    """Say that a component is out of service (semantics 7.5); None: it is not."""
    outage = state.out_of_service.get(component)
    if outage is None:
        return None
    what = sentence('waits_for_service', component=component, words=outage.reason)
    return Wait(what, WaitKind.OUT_OF_SERVICE, component)


def waits_for_readiness(state: CellState, component: str) -> Wait | None:
    """Say what the state topic of a component does not say (semantics 2.5); None: it is ready."""
    topic, reading = state.cell.components[component].state, state.readings[component]
    if topic is None or reading.ready:
        return None
    finding = 'nothing is published there' if reading.value is None else f'it is {reading.value}'
    return Wait(f'waiting for {topic}; {finding}', WaitKind.READINESS, component)


# --- jobs -----------------------------------------------------------------------------------


def feeding_job(state: CellState) -> JobState | None:
    """Return the first job that has source cycles left and is not held (semantics 6.1, 6.6)."""
    for job in state.jobs.line.values():
        if job.cycles_left > 0:
            return job
    return state.jobs.next


def may_not_begin(state: CellState, job: JobState) -> Wait | None:
    """Say what keeps a job from its first initialization task, or cycle (semantics 6.6)."""
    if job.started:
        return None
    if state.stop_after is not None:
        return _the_line_stops(state.stop_after)
    return None


def _may_not_feed(state: CellState, job: JobState) -> Wait | None:
    """Say what keeps a job from its next item (semantics 6.6)."""
    if job.piece:
        what = f'{job.job.id} waits for the approval of {job.piece}'
        return Wait(what, WaitKind.PAUSE, job.job.id)
    if job.paused:
        return Wait(f'waiting for {job.job.id} to be resumed', WaitKind.PAUSE, job.job.id)
    if state.stop_after == 'item':
        return _the_line_stops(state.stop_after)
    return may_not_begin(state, job)


def is_first_piece(state: CellState, job: JobState, section: int) -> bool:
    """Tell whether a job waits for the approval of the item that a section begins (6.12)."""
    if section != job.job.script.source or not job.cycles_left:
        return False
    return state.cell.first_piece is not Approval.AUTOMATIC


def _the_line_stops(after: str) -> Wait:
    return Wait(f'the line stops after the current {after}', WaitKind.CELL_STATE, after)


def is_done_with(state: CellState, section: SectionState, job: JobState) -> bool:
    """Tell whether a section has no more work for a job (semantics 6.1)."""
    if job.cycles_left or (section.cycle and section.cycle.job == job.job.id):
        return False
    return not any(
        not item.gone and is_ahead(state, section, item.section, job)
        for item in job.items.values()
    )


def is_ahead(state: CellState, section: SectionState, at: int, job: JobState) -> bool:
    """Tell whether an item at a position still has to pass through a section."""
    if at == section.number:
        unhandled = section.turn_beat < state.beat
        return unhandled and job.job.script.sections.get(at) is not None
    return (at or job.job.script.source) < section.number


def waits_for_earlier_jobs(state: CellState, job: str, sections: tuple[int, ...]) -> Wait | None:
    """Say which earlier job keeps sections from preparing for a job (semantics 5.2)."""
    for earlier in state.jobs.before(job):
        for number in sections:
            if not is_done_with(state, state.sections[number], earlier):
                name = earlier.job.id
                what = f'waiting for section {number} to finish {name}'
                return Wait(what, WaitKind.JOB, name, sections=(number,))
    return None


def waits_for_initialization(state: CellState, job: str, section: int) -> Wait | None:
    """Say which initialization task keeps a section from a cycle for a job (semantics 5.2).

    Including those of earlier jobs: done later, they would change the setup of this job.
    """
    for earlier in state.jobs.before(job):
        wait = waits_for_tasks(state, earlier, _preparation(state, earlier).of_section[section])
        if wait is not None:
            return wait
    live = state.jobs[job]
    return waits_for_tasks(state, live, _preparation(state, live).needed_by(section))


def waits_for_tasks(state: CellState, job: JobState, tasks: Iterable[Task]) -> Wait | None:
    """Say which of some initialization tasks of a job is not done."""
    name = job.job.id
    for task in tasks:
        if state.phase(TaskKey(name, None, None, task.id)) is not Phase.DONE:
            what = f'waiting for initialization {task.id} of {name}'
            return Wait(what, WaitKind.INITIALIZATION, task.id, task=task.id)
    return None


def _preparation(state: CellState, job: JobState) -> Preparation:
    return state.preparations[job.digest]


def is_complete(state: CellState, job: JobState) -> bool:
    """Tell whether nothing of a job remains (semantics 6.1)."""
    if job.cycles_left or job.items:
        return False
    return all(
        state.phase(TaskKey(job.job.id, None, None, task.id)) is Phase.DONE
        for task in job.job.script.initialization
    )


# --- cycles ---------------------------------------------------------------------------------


def next_cycle(state: CellState, section: SectionState) -> Start | Wait:
    """Return the cycle that a section without one may begin now (semantics 3.4, 3.7)."""
    stopped = stopped_because(state)
    if stopped:
        return stopped
    if state.indexing:
        return _ahead_of_the_move(state, section)
    if section.slot is not None and section.turn_beat < state.beat:
        arrived = _for_item(state, section, section.slot, state.beat)
        if arrived is not None:
            return arrived
    taken = section.turn_beat >= state.beat or section.slot is not None
    beat = state.beat + 1 if taken else state.beat
    return _at_source(state, section, beat) or _idle(state, section)


def waits_without_work(state: CellState, *, has_item: bool) -> Wait:
    """Say what a section without work for its item, or for any to come, waits for.

    The common answer of `next_cycle` for all these sections; no source is among them.
    """
    stopped = stopped_because(state)
    if stopped or state.indexing:
        return stopped or _UNREST
    return _TO_MOVE if has_item else _without_item(state)


_UNREST = Wait('waiting for the belt to rest', WaitKind.BELT)
_TO_MOVE = Wait('waiting for the belt to move', WaitKind.BELT)


def _ahead_of_the_move(state: CellState, section: SectionState) -> Start | Wait:
    if section.turn_beat > state.beat:
        return _UNREST  # never more than one cycle ahead
    if section.number > 1:
        coming = state.sections[section.number - 1].slot
        if coming is not None:
            arriving = _for_item(state, section, coming, state.beat + 1)
            if arriving is not None:
                return arriving
    return _at_source(state, section, state.beat + 1) or _UNREST


def _for_item(
    state: CellState, section: SectionState, item: str, beat: int
) -> Start | Wait | None:
    job = state.items[item].job
    if task_list(state, job, section.number) is None:
        return None
    return waits_for_initialization(state, job, section.number) or Start(job, item, beat)


def _at_source(state: CellState, section: SectionState, beat: int) -> Start | Wait | None:
    job = feeding_job(state)
    if job is None or job.job.script.source != section.number:
        return None
    name = job.job.id
    return (
        _may_not_feed(state, job)
        or waits_for_earlier_jobs(state, name, (section.number,))
        or _waits_for_position(state, job, beat)
        or waits_for_initialization(state, name, section.number)
        or Start(name, job.job.item(job.progress.started + 1), beat)
    )


def _waits_for_position(state: CellState, job: JobState, beat: int) -> Wait | None:
    """Say with whose item a job's first item would collide in a given beat (semantics 6.1).

    The source of the job before may be downstream of this one, and have begun ahead. An item goes
    one section a beat, so beat less section is its place in the order of the belt.
    """
    if job.progress.started:
        return None
    place = beat - job.job.script.source
    for section in state.sections.values():
        cycle = section.cycle
        if cycle is not None and cycle.beat - section.number >= place:
            what = f'waiting for section {section.number} to place {cycle.item}'
            return Wait(what, WaitKind.JOB, cycle.job, sections=(section.number,))
    return None


def _idle(state: CellState, section: SectionState) -> Wait:
    if section.slot is not None:
        return _TO_MOVE
    return _without_item(state)


def _without_item(state: CellState) -> Wait:
    if state.has_work:
        return Wait('waiting for an item', WaitKind.ITEM)
    return Wait('waiting for a job', WaitKind.JOB)


# --- the belt -------------------------------------------------------------------------------


class Advance(Enum):
    """The work of the belt at the end of a beat."""

    INDEX = 'index'
    NEXT_BEAT = 'next beat'
    """The next beat begins without a move, the belt being empty (semantics 3.5)."""


class Overrun(NamedTuple):
    """An item would be moved out of the last section (semantics 3.6)."""

    item: str


def end_of_beat(state: CellState, owing: Mapping[int, str]) -> Advance | Overrun | Wait:
    """Return what the belt at rest does now (semantics 3.5).

    :param owing: what sections still have to do in this beat, by their number (`owes_turn`)
    """
    if owing:
        return Wait('; '.join(owing.values()), WaitKind.TURN, sections=tuple(owing))
    last = state.slot(state.cell.conveyor.sections)
    if last is not None and last.present:
        return Overrun(last.id)
    stopped = stopped_because(state)
    if stopped:
        return stopped
    if any(section.slot for section in state.sections.values()):
        conveyor = state.cell.conveyor.component.name
        unavailable = waits_for_service(state, conveyor) or waits_for_readiness(state, conveyor)
        return unavailable or Advance.INDEX
    if _is_begun_ahead(state) or _source_may_begin(state):
        return Advance.NEXT_BEAT
    return Wait('waiting for an item on the belt', WaitKind.ITEM)


def owes_turn(state: CellState, section: SectionState) -> str | None:
    """Say what a section still has to do in this beat (semantics 3.4)."""
    if section.turn_beat >= state.beat:
        return None
    if section.cycle is not None and section.cycle.beat == state.beat:
        return f'waiting for section {section.number} to finish with {section.cycle.item}'
    if section.slot is not None:
        job = state.items[section.slot].job
        if task_list(state, job, section.number) is not None:
            return f'waiting for section {section.number} to begin with {section.slot}'
        return None
    if isinstance(_at_source(state, section, state.beat), Start):
        return f'waiting for section {section.number} to place the next item'
    return None


def _is_begun_ahead(state: CellState) -> bool:
    """Tell whether a cycle waits for the next beat; it may be the last one (semantics 3.5)."""
    cycles = (section.cycle for section in state.sections.values())
    return any(cycle is not None and cycle.beat > state.beat for cycle in cycles)


def _source_may_begin(state: CellState) -> bool:
    job = feeding_job(state)
    if job is None:
        return False
    section = state.sections[job.job.script.source]
    return isinstance(_at_source(state, section, state.beat + 1), Start)
