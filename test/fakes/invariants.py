"""What holds in every run, checked by a fold of its own (not by `model.fold`)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from typing import ClassVar

from fakes.initialization_invariants import InitializationInvariants
from fakes.queue_invariants import QueueInvariants
from fakes.service_invariants import ServiceInvariants

from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.packml import MANUAL_FROM, TRANSITIONS, Cause, PackmlState
from bt_orchestrator.model.script import Script

FREEING = (e.TaskSkipped, e.TaskContinued, e.TaskMarkedDone)
"""Events after which a task has no component any more, whatever was in doubt."""

AT_REST = (
    PackmlState.STOPPED,
    PackmlState.RESETTING,
    PackmlState.IDLE,
    PackmlState.COMPLETE,
    PackmlState.ABORTING,
    PackmlState.ABORTED,
    PackmlState.CLEARING,
)
"""States in which no task starts."""

EMPTY_HANDED = (
    PackmlState.STOPPED,
    PackmlState.SUSPENDED,
    PackmlState.ABORTED,
    PackmlState.IDLE,
    PackmlState.COMPLETE,
)
"""States that are entered only when no goal is in flight."""


class Invariants:
    """Follows the events of one cell and raises AssertionError at the first that cannot be."""

    def __init__(self, cell: Cell) -> None:
        self._cell = cell
        self._seen = 0
        self._time = 0.0
        self._scripts: dict[str, Script] = {}
        self._jobs: dict[str, Script] = {}
        self._slots: dict[int, str] = {}
        self._there: set[str] = set()
        """Items that stand on the belt."""
        self._placed = 0
        self._out: Counter[str] = Counter()
        self._live: set[str] = set()
        self._flags: dict[str, tuple[int, int, int]] = {}
        """Count, capacity and initial count."""
        self._busy: dict[str, e.TaskKey] = {}
        self._used: dict[e.TaskKey, str] = {}
        """Tasks that had an attempt, with their components."""
        self._in_flight: set[str] = set()
        """Goals that were sent and have not ended."""
        self._zones: dict[str, e.TaskKey] = {}
        self._moving = False
        self._queue = QueueInvariants(cell)
        self._initialization = InitializationInvariants(cell, self._jobs)
        self._service = ServiceInvariants(cell, self._scripts)
        self._ended: set[tuple[str | None, str]] = set()
        """Items with the tasks that ended for them, one way or the other."""
        self._mode = PackmlState.STOPPED
        self._pauses: set[str] = set()
        self._is_manual = False

    def follow(self, event: e.Event) -> None:
        """Take in the next event."""
        self._seen += 1
        assert event.seq == self._seen, event
        assert event.time >= self._time, event
        self._time = event.time
        self._take(event)
        self._queue.take(event)
        self._initialization.take(event)
        self._service.take(event)
        self._check(event)

    def _check(self, event: e.Event) -> None:
        assert self._placed == sum(self._out.values()) + len(self._there), event
        for flag, (count, capacity, _) in self._flags.items():
            assert 0 <= count <= capacity, (flag, event)
        for key in self._busy.values():
            assert not (self._moving and self._needs_belt(key)), (key, event)

    def _take(self, event: e.Event) -> None:
        for kind, take in self._takers.items():
            if isinstance(event, kind):
                take(self, event)

    # --- jobs and flags ---------------------------------------------------------------------

    def _script_loaded(self, event: e.ScriptLoaded) -> None:
        self._scripts[event.digest] = event.definition

    def _job_queued(self, event: e.JobQueued | e.JobUpdated) -> None:
        script = self._scripts[event.digest]
        self._live.discard(event.job)
        for dependency in script.dependencies:
            known = [d for name in self._live for d in self._jobs[name].dependencies]
            if dependency.flag not in [d.flag for d in known]:
                before = self._flags.get(dependency.flag)
                assert before is None or before[0] == before[2], 'it did not come back (4.3)'
                self._flags[dependency.flag] = (
                    dependency.initial,
                    dependency.capacity,
                    dependency.initial,
                )
        self._jobs[event.job] = script
        self._live.add(event.job)

    def _job_ended(self, event: e.JobCompleted | e.JobAborted | e.JobRemoved) -> None:
        self._live.remove(event.job)

    def _flag(self, event: e.FlagEvent) -> None:
        count, capacity, initial = self._flags[event.flag]
        change = 1 if isinstance(event, e.FlagRaised) else -1
        assert event.count == count + change, event
        self._flags[event.flag] = event.count, capacity, initial

    # --- components and zones ---------------------------------------------------------------

    def _started(self, event: e.TaskStarted) -> None:
        assert not self._pauses, (event, self._pauses)
        self._in_flight.add(event.goal)
        if event.key == e.MANUAL_KEY:
            assert self._is_manual, event
            assert self._mode in MANUAL_FROM, (event, self._mode)
            assert not self._there, event
            return
        assert not self._is_manual, event
        assert self._mode not in AT_REST, (event, self._mode)
        self._used[event.key] = event.component
        self._take_for(event.key)

    def _take_for(self, key: e.TaskKey) -> None:
        """Let a task have its component and zones, if nobody else has (2.5, 4.4)."""
        component = self._used[key]
        assert not component or self._busy.setdefault(component, key) == key, (key, self._busy)
        for zone in self._zones_of(key):
            assert self._zones.setdefault(zone, key) == key, (zone, key, self._zones)

    def _succeeded(self, event: e.TaskSucceeded) -> None:
        self._in_flight.remove(event.goal)
        self._free(event)

    def _failed(self, event: e.TaskFailed) -> None:
        self._in_flight.discard(event.goal or '')
        if event.reason == 'setup_missing' and event.key in self._used:
            self._used[event.key] = ''  # the change needs its component (5.3)
        self._free(event)  # until it is held

    def _free(self, event: e.TaskEvent) -> None:
        if not isinstance(event, e.TaskFailed):
            self._ended.add((event.item, event.task))
        self._free_of(event.key)

    def _free_of(self, task: e.TaskKey) -> None:
        for owners in (self._busy, self._zones):
            for name in [name for name, key in owners.items() if key == task]:
                del owners[name]

    def _round_begun(self, event: e.RoundBegun) -> None:
        for task in event.tasks:
            self._ended.discard((event.item, task))
            self._free_of(e.TaskKey(event.job, event.section, event.item, task))

    def _zones_of(self, key: e.TaskKey) -> list[str]:
        if key.job is None:
            return []
        return [z.name for z in self._jobs[key.job].zones if key.task in z.tasks]

    def _needs_belt(self, key: e.TaskKey) -> bool:
        if key.job is None or key.section is None:
            return False
        steps = self._jobs[key.job].sections[key.section].steps
        step = next(s for s in steps if key.task in [task.id for task in s.tasks])
        return any(task.requires_conveyor for task in step.tasks)

    # --- the belt and its items -------------------------------------------------------------

    def _index_started(self, _: e.BeltIndexStarted) -> None:
        assert not self._moving
        self._moving = True

    def _indexed(self, _: e.BeltIndexed) -> None:
        assert self._moving
        self._moving = False

    def _stands(self, event: e.ItemPlaced | e.ItemMissing) -> None:
        assert event.section not in self._slots, event
        self._slots[event.section] = event.item
        if isinstance(event, e.ItemPlaced):
            self._placed += 1
            self._there.add(event.item)

    def _moved(self, event: e.ItemMoved) -> None:
        assert self._moving, event
        assert event.section not in self._slots, event
        assert self._slots.pop(event.section - 1) == event.item, event
        self._slots[event.section] = event.item
        owed = self._jobs[event.job].sections.get(event.section - 1)
        for step in owed.steps[: owed.turn_steps] if owed else ():
            for task in step.tasks:
                assert (event.item, task.id) in self._ended, (task.id, event)

    def _removed(self, event: e.ItemRemoved) -> None:
        assert event.item in self._there, event
        assert event.section is not None
        assert self._slots[event.section] == event.item, event
        self._there.remove(event.item)
        self._out[event.how] += 1
        script = self._jobs[event.job]
        if event.how != 'by_hand' and event.section == script.sink:
            del self._slots[event.section]

    def _position_ended(self, event: e.PositionEnded) -> None:
        assert event.item not in self._there, event
        assert self._slots.pop(event.section) == event.item, event

    # --- the cell as a whole ----------------------------------------------------------------

    def _state_changed(self, event: e.CellStateChanged) -> None:
        assert event.previous == self._mode.value, event
        assert TRANSITIONS[self._mode][Cause(event.cause)] is PackmlState(event.state), event
        self._mode = PackmlState(event.state)
        assert self._mode not in EMPTY_HANDED or not self._in_flight, (event, self._in_flight)

    def _mode_changed(self, event: e.UnitModeChanged) -> None:
        assert not self._in_flight, event
        assert not self._there, event
        self._is_manual = event.mode == 'manual'

    def _hold_raised(self, event: e.HoldRaised) -> None:
        if event.task is None and event.item is None and event.reason != 'too_many_rejects':
            self._pauses.add(event.hold)
        key = e.TaskKey(event.job, event.section, event.item, event.task or '')
        if key in self._used:
            self._take_for(key)

    def _hold_released(self, event: e.HoldReleased) -> None:
        self._pauses.discard(event.hold)

    _takers: ClassVar[Mapping[type[e.Event], Callable[..., None]]] = {
        e.ScriptLoaded: _script_loaded,
        e.JobQueued: _job_queued,
        e.JobUpdated: _job_queued,
        e.JobRemoved: _job_ended,
        e.JobCompleted: _job_ended,
        e.JobAborted: _job_ended,
        e.FlagEvent: _flag,
        e.TaskStarted: _started,
        e.TaskSucceeded: _succeeded,
        e.TaskFailed: _failed,
        e.BeltIndexStarted: _index_started,
        e.BeltIndexed: _indexed,
        e.ItemPlaced: _stands,
        e.ItemMissing: _stands,
        e.ItemMoved: _moved,
        e.ItemRemoved: _removed,
        e.PositionEnded: _position_ended,
        e.RoundBegun: _round_begun,
        e.CellStateChanged: _state_changed,
        e.UnitModeChanged: _mode_changed,
        e.HoldRaised: _hold_raised,
        e.HoldReleased: _hold_released,
        **dict.fromkeys(FREEING, _free),
    }
