"""Whether what is told of waits is what is in the way: each obstacle taken away in a copy.

A wait is right if the task starts, or names another one, once its obstacle is gone, and does not
start while that obstacle is the only one left. The engine decides what starts.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeAlias

from bt_orchestrator.model import events as e
from bt_orchestrator.model.fold import apply
from bt_orchestrator.model.frozen import changed
from bt_orchestrator.model.keeping.snapshot import state_from_plain, state_to_plain
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.state import CellState, Phase, Reading, TaskState
from bt_orchestrator.model.stop_reason import AFTER
from bt_orchestrator.model.wait import BELT, Wait, WaitKind
from bt_orchestrator.model.waits.waiting import by_part
from bt_orchestrator.sim.past import StillEngine

if TYPE_CHECKING:
    from fakes.virtual_run import VirtualRun

Subject: TypeAlias = e.TaskKey | int | str
"""What waits: a task, a section that may begin with the item that stands there, or the belt."""

MOST = 20
"""More obstacles than this nothing has: one comes again and again."""

_ATTEMPTS = (e.TaskStarted, e.TaskSkipped, e.TaskFailed)


class Obstacles:
    """Looks at some moments of a run."""

    def __init__(self, run: VirtualRun, every: int) -> None:
        """Look at every so-manieth settle from now on."""
        self.kinds: Counter[WaitKind] = Counter()
        """How often an obstacle of each kind was taken away."""
        self._settles, self._check = 0, run.check_reasons

        def check() -> None:
            self._check()
            self._settles += 1
            if self._settles % every == 0:
                self.look(run.state)

        run.check_reasons = check  # type: ignore[method-assign]

    def look(self, state: CellState) -> None:
        """Check what is told of everything that waits now."""
        for subject in _subjects(state):
            self._look(state, subject)

    def _look(self, state: CellState, subject: Subject) -> None:
        waits: list[Wait] = []
        free = _copied(state)
        while (wait := _told(free, subject)) is not None:
            assert wait not in waits, (subject, waits, wait)
            assert len(waits) < MOST, (subject, waits)
            if wait.kind in (WaitKind.ITEM, WaitKind.JOB) or (
                wait.kind is WaitKind.BELT and isinstance(subject, int)
            ):
                return  # it has no work now
            waits.append(wait)
            _remove(free, wait, subject)
        ticked, events = _ticked(free)
        is_begun = any(_begins(event, subject) for event in events)
        assert is_begun or _told(ticked, subject) not in (None, *waits), (subject, waits)
        self.kinds.update(wait.kind for wait in waits)
        for only in waits if len(waits) > 1 else ():  # else it is the run itself that shows it
            left = _copied(state)
            for wait in waits:
                if wait is not only:
                    _remove(left, wait, subject)
            assert _told(left, subject) is not None, (subject, only, waits)
            _check_order(left, subject)


def _check_order(state: CellState, subject: Subject) -> None:
    """Fail if something begins while a wait is told of it: others may have ended that wait."""
    for event in _ticked(_copied(state))[1]:
        if _begins(event, subject):
            assert _told(state, subject) is None, (subject, event)
        apply(state, event)


def _subjects(state: CellState) -> Sequence[Subject]:
    """Return what waits: next tasks, sections whose item is still to do, and the belt."""
    subjects: list[Subject] = []
    for part, waiting in by_part(state, _Unseen(state)).items():
        for entry in waiting:
            section = state.sections.get(part) if isinstance(part, int) else None
            if entry.tasks and entry.tasks != (e.INDEX_KEY,):
                subjects += entry.tasks
            elif part == BELT or (section and section.slot and section.turn_beat < state.beat):
                subjects.append(part)
    return [entry for entry in subjects if entry != BELT or not state.indexing]


def _told(state: CellState, subject: Subject) -> Wait | None:
    """Return what something waits for."""
    parts = by_part(state, _Unseen(state))
    if isinstance(subject, e.TaskKey):
        waiting = (entry for part in parts.values() for entry in part if subject in entry.tasks)
        return next((entry.wait for entry in waiting), None)
    return next((entry.wait for entry in parts[subject]), None)


def _begins(event: e.Event, subject: Subject) -> bool:
    if isinstance(subject, e.TaskKey):
        return isinstance(event, _ATTEMPTS) and event.key == subject
    if isinstance(subject, int):
        return isinstance(event, e.CycleStarted) and event.section == subject
    return isinstance(event, (e.BeltIndexStarted, e.BeatStarted))


class _Unseen:
    """Servers and clocks of a state that nobody runs."""

    def __init__(self, state: CellState) -> None:
        self._state = state

    def rivals(self, component: str) -> Sequence[str]:
        return ()

    def is_delayed(self, key: e.TaskKey) -> bool:
        return (
            self._state.tasks[key].delay_s > 0
            and self._state.tasks[key].not_before > self._state.time
        )

    def awaits_setup(self, key: e.TaskKey) -> bool:
        return True


def _copied(state: CellState) -> CellState:
    return state_from_plain(state.cell, json.loads(json.dumps(state_to_plain(state))))


def _ticked(state: CellState) -> tuple[CellState, Sequence[e.Event]]:
    """Return what the engine makes of a state at once, and by which events."""
    engine = StillEngine(state)
    try:
        ledger = engine._ledger
        return ledger.state, ledger.pending_after(0)
    finally:
        engine.close()


def _remove(state: CellState, wait: Wait, subject: Subject) -> None:
    """Take an obstacle away."""
    match wait.kind:
        case WaitKind.HOLD | WaitKind.PAUSE:
            for name in wait.holds or (wait.name,):
                _end_hold(state, name)
        case WaitKind.CELL_STATE if wait.name in AFTER:
            state.stop_after = None
        case WaitKind.CELL_STATE:
            state.packml, state.shutting_down = PackmlState.EXECUTE, False
        case WaitKind.OUT_OF_SERVICE:
            del state.out_of_service[wait.name]
        case WaitKind.READINESS:
            state.readings[wait.name] = Reading(True)
            state.contests.pop(wait.name, None)
        case WaitKind.COMPONENT:
            del state.reserved[wait.name]
        case WaitKind.ZONE:
            del state.zones[wait.name]
        case WaitKind.FLAG:
            flag = state.flags[wait.name]
            flag.count = flag.capacity - 1 if flag.count else 1
        case WaitKind.RETRY_DELAY:
            assert isinstance(subject, e.TaskKey)
            _begin_again(state, subject)
        case WaitKind.INITIALIZATION:
            for job in state.jobs.values():
                key = e.TaskKey(job.job.id, None, None, wait.task)
                state.tasks[key] = TaskState(Phase.DONE)
        case WaitKind.TURN:
            for number in wait.sections:
                state.sections[number].turn_beat = state.beat
        case WaitKind.BELT:
            assert isinstance(subject, e.TaskKey), (subject, wait)
            cycle = state.sections[subject.section or 0].cycle
            assert cycle is not None
            if state.beat < cycle.beat:
                slots = [None, *(state.sections[n].slot for n in sorted(state.sections))]
                for number, slot in enumerate(slots[:-1], 1):
                    state.sections[number].slot = slot
            state.indexing, state.beat = False, cycle.beat
        case _:
            raise AssertionError(f'nobody can take away {wait}')


def _end_hold(state: CellState, name: str) -> None:
    """Take away a hold, the item that one is about, or what pauses a job."""
    if name in state.holds:
        del state.holds[name]
    elif name in state.items:
        state.sections[state.items[name].section].slot = None
    else:
        state.jobs[name].paused = False
    for key, task in list(state.tasks.items()):
        if task.phase is Phase.HELD and task.hold == name:
            _begin_again(state, key)


def _begin_again(state: CellState, key: e.TaskKey) -> None:
    again = {'phase': Phase.RETRYING, 'hold': None, 'not_before': 0.0, 'delay_s': 0.0}
    state.tasks[key] = changed(state.tasks[key], **again, delayed_up=None)
