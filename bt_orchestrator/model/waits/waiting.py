"""The present waits of everything: the one teller of waits (semantics 7.4).

It reads the state by the rules that let tasks start and the belt move (`starting`, `line`), so the
same is told live, of a past moment, and in a record that was folded from a journal.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import chain
from typing import NamedTuple

from bt_orchestrator.model import events as e
from bt_orchestrator.model.failures import may_repeat
from bt_orchestrator.model.frozen import changed
from bt_orchestrator.model.hold_words import hold_wait_words
from bt_orchestrator.model.line import (
    Advance,
    Overrun,
    end_of_beat,
    next_cycle,
    owes_turn,
    task_list,
)
from bt_orchestrator.model.script import Task, index_task
from bt_orchestrator.model.state import CellState, ItemState, Phase, SectionState
from bt_orchestrator.model.wait import BELT, GRAVE, INITIALIZATION, Wait, WaitKind
from bt_orchestrator.model.waits.starting import (
    Seen,
    before_attempt,
    stopped_task,
    waits_for_belt,
    waits_for_flag,
    waits_for_one_server,
    waits_for_preparation,
    waits_for_topic,
    waits_for_zone,
    waits_in_hold,
)


class Waiting(NamedTuple):
    """Something that does not begin."""

    wait: Wait
    tasks: tuple[e.TaskKey, ...] = ()
    """The tasks; empty: a cycle, or an item that is done here."""
    components: tuple[str, ...] = ()
    """Those that it blocks."""


def together(waitings: Iterable[Waiting]) -> tuple[Wait, ...]:
    """Return waits, each once, with the components that they block."""
    blocked: dict[Wait, dict[str, None]] = {}
    for waiting in waitings:
        blocked.setdefault(waiting.wait, {}).update(dict.fromkeys(waiting.components))
    return tuple(
        changed(wait, components=tuple(names)) if names else wait
        for wait, names in blocked.items()
    )


# --- tasks --------------------------------------------------------------------------------------


def _of_task(state: CellState, key: e.TaskKey, task: Task, seen: Seen) -> Iterator[Waiting]:
    """Yield what a task waits for; nothing if it has a goal, or has passed."""
    wait = _wait_of(state, key, task, seen)
    if wait is not None:
        yield Waiting(wait, (key,), (task.component,))


def _wait_of(state: CellState, key: e.TaskKey, task: Task, seen: Seen) -> Wait | None:
    progress = state.tasks.get(key)
    if progress is None or progress.phase is Phase.RETRYING:
        obstacle = _guarded(state, key, task) or before_attempt(state, key, task, seen)
        return obstacle if isinstance(obstacle, Wait) else None
    if progress.phase is Phase.HELD:
        hold = state.holds[progress.hold or '']
        return Wait(hold_wait_words([hold]), WaitKind.HOLD, hold.id)
    is_refused = progress.phase is Phase.FAILED and key.item and may_repeat(state, key, task)
    return stopped_task(state, key) if is_refused else None


def _guarded(state: CellState, key: e.TaskKey, task: Task) -> Wait | None:
    """Return what the guards around a task wait for, the outermost first."""
    if key.job is None:
        return waits_for_topic(state, key, task)
    if key.section is None:
        wait = waits_for_preparation(state, key, task)
        if wait is not None:
            return wait
    script = state.script(key.job)
    flags = (*script.upstream_of.get(key.task, ()), *script.downstream_of.get(key.task, ()))
    for flag in reversed(flags if key.section is not None else ()):
        wait = waits_for_flag(state, key, flag)
        if wait is not None:
            return wait
    for zone in reversed(script.zones_of.get(key.task, ())):
        wait = waits_for_zone(state, key, task, zone)
        if wait is not None:
            return wait
    return waits_for_topic(state, key, task)


# --- parts of the cell --------------------------------------------------------------------------


def of_initialization(state: CellState, seen: Seen) -> Iterator[Waiting]:
    """Yield what the initialization of the jobs at work waits for."""
    for job in state.jobs.at_work():
        for task in job.job.script.initialization:
            yield from _of_task(state, e.TaskKey(job.job.id, None, None, task.id), task, seen)


def of_section(state: CellState, section: SectionState, seen: Seen) -> Iterator[Waiting]:
    """Yield what the next tasks of a section's cycle wait for, or its next cycle."""
    cycle = section.cycle
    if cycle is None:
        begin = next_cycle(state, section)
        if isinstance(begin, Wait):
            yield Waiting(begin)
        return
    for step in state.script(cycle.job).sections[section.number].steps:
        keys = {t.id: e.TaskKey(cycle.job, section.number, cycle.item, t.id) for t in step.tasks}
        tracks = (
            (task for task in track if not _is_done(state, keys[task.id])) for track in step.tracks
        )
        pending = [task for task in (next(track, None) for track in tracks) if task is not None]
        if not pending:
            continue
        belt = waits_for_belt(state, cycle) if step.requires_conveyor else None
        if belt is not None:
            components = tuple(dict.fromkeys(task.component for task in step.tasks))
            yield Waiting(belt, tuple(keys[task.id] for task in pending), components)
            return
        for task in pending:
            yield from _of_task(state, keys[task.id], task, seen)
        return


def _is_done(state: CellState, key: e.TaskKey) -> bool:
    return state.phase(key) is Phase.DONE


def of_belt(state: CellState, seen: Seen) -> Iterator[Waiting]:
    """Yield what the belt waits for before it moves, or why its move has no goal."""
    conveyor = state.cell.conveyor
    if state.indexing:
        yield from _of_task(state, e.INDEX_KEY, index_task(state.cell), seen)
        return
    due: Advance | Overrun | Wait = end_of_beat(state, _owing(state))
    if due is Advance.INDEX:
        due = waits_for_one_server(state, conveyor.component.name, seen) or due
    if isinstance(due, Overrun):
        what = f'waiting for {due.item} to be removed'
        due = Wait(what, WaitKind.HOLD, due.item, sections=(conveyor.sections,))
    if isinstance(due, Wait):
        yield Waiting(due, components=(conveyor.component.name,))


def _owing(state: CellState) -> Mapping[int, str]:
    owed = ((number, owes_turn(state, section)) for number, section in state.sections.items())
    return {number: words for number, words in owed if words is not None}


def by_part(state: CellState, seen: Seen) -> Mapping[str | int, Iterator[Waiting]]:
    """Return what each part waits for, in the order of the belt; sections by their numbers."""
    waits: dict[str | int, Iterator[Waiting]] = {INITIALIZATION: of_initialization(state, seen)}
    for number in sorted(state.sections):
        waits[number] = of_section(state, state.sections[number], seen)
    waits[BELT] = of_belt(state, seen)
    return waits


def unready(state: CellState, seen: Seen) -> Iterator[e.TaskKey]:
    """Yield the tasks that could start if their component were ready, the last section first."""
    first, *sections, belt = by_part(state, seen).values()
    for waiting in chain(first, *reversed(sections), belt):
        if waiting.wait.kind is WaitKind.READINESS and not state.stops:
            yield from (key for key in waiting.tasks if waits_in_hold(state, key) is None)


# --- items --------------------------------------------------------------------------------------


def of_item(state: CellState, item: ItemState, seen: Seen) -> Iterator[Waiting]:
    """Yield what the next tasks of an item wait for; if it is done here, what the belt waits for.

    Nothing, where a goal of it runs, or the belt carries it on.
    """
    for other in state.sections.values():
        if other.cycle is not None and other.cycle.item == item.id:
            yield from of_section(state, other, seen)
    section = state.sections.get(item.section)
    if section is None or (section.cycle is not None and section.cycle.item == item.id):
        return
    waitings: Iterable[Waiting]
    is_to_do = section.turn_beat < state.beat and task_list(state, item.job, section.number)
    if not is_to_do:
        waitings = of_belt(state, seen)
    elif section.cycle is None:
        waitings = of_section(state, section, seen)
    else:
        what = f'waiting for section {section.number} to finish with {section.cycle.item}'
        waitings = [Waiting(Wait(what, WaitKind.TURN, sections=(section.number,)))]
    tasks = _next_tasks(state, item, section.number if is_to_do else section.number + 1)
    yield from (waiting._replace(tasks=tasks) for waiting in waitings)


def _next_tasks(state: CellState, item: ItemState, section: int) -> tuple[e.TaskKey, ...]:
    """Return the first tasks of an item in a section, or in the next one that has any for it."""
    lists = state.script(item.job).sections
    number = min((number for number in lists if number >= section), default=None)
    if number is None:
        return ()
    first = (track[0].id for track in lists[number].steps[0].tracks)
    return tuple(e.TaskKey(item.job, number, item.id, task) for task in first)


def at_bottom(state: CellState, wait: Wait, seen: Seen) -> Wait:
    """Return what a wait comes to in the end.

    From the belt to what it waits for, and from the turn of a section to what stops that section,
    if somebody has to do something about that.
    """
    here, pending, passed = wait, deque([wait]), set[int | str]()
    while pending:
        next_wait = pending.popleft()
        if next_wait.kind in GRAVE and next_wait.kind is not WaitKind.RETRY_DELAY:
            return next_wait
        here = next_wait if here.kind is WaitKind.BELT else here
        sections = next_wait.sections if next_wait.kind is WaitKind.TURN else ()
        parts: Sequence[int | str] = (BELT,) if next_wait.kind is WaitKind.BELT else sections
        for part in (part for part in parts if part not in passed):
            passed.add(part)
            pending += (waiting.wait for waiting in by_part(state, seen)[part])
    return here
