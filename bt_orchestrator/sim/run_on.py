"""The engine of a cell, run on in virtual time from the state of some moment.

Tasks take their observed durations, else the nominal ones, and goals in flight the rest of that;
everything else is as in any virtual run.
"""

from __future__ import annotations

import json
import math
import time
from collections import defaultdict
from collections.abc import Callable, Hashable, Mapping, Sequence
from contextlib import closing
from dataclasses import replace
from typing import Any

from bt_orchestrator.engine.runtime.job_overview import Unknown
from bt_orchestrator.engine.runtime.observed_durations import as_observed
from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Approval, Cell
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.goal import GoalRequest
from bt_orchestrator.model.judging.used_ids import text_of
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.state import CellState, Cycle, Phase
from bt_orchestrator.model.stop_reason import RESTARTED
from bt_orchestrator.model.words import sentence
from bt_orchestrator.ports import ActionTypes, EventSink, Snapshot
from bt_orchestrator.sim.gateway import VirtualClock, VirtualGateway
from bt_orchestrator.sim.virtual_client import VirtualGoal

CYCLES_RUN = 40
"""Number of cycles run of each job; omitted ones are assumed at the pace in the middle."""

CYCLES_KEPT = 2
"""Number of cycles still to begin that are run of a job once the line repeats itself."""

DECIMALS = 3
"""Of the seconds in which two moments of a line are compared."""

LONGEST_S = 10.0
"""Seconds of real time for one run; jobs that have not ended then have no forecast."""


class RunOn:
    """A virtual run that begins with the state of a real one, without affecting it."""

    def __init__(
        self,
        cell: Cell,
        types: ActionTypes,
        plain_state: Mapping[str, Any],
        observed_s: Mapping[str, Mapping[str, float]],
        now_s: float,
        sinks: Sequence[EventSink] = (),
    ) -> None:
        """Begin with the given state of a cell.

        :param plain_state: of `model.keeping.snapshot`
        :param observed_s: seconds that tasks took, by component and task constant
        :param now_s: the moment on the clock of the state
        :param sinks: get the events of the run
        """
        self._log = _Log(cell)
        self.steps = 0
        """So often something has happened: what the run has cost, on any machine."""
        self._left_out: dict[str, int] = {}
        self._stood: dict[Hashable, int] = {}
        """How many items of a job were packed when the line first stood like this."""
        self._stuck = sentence('run_given_up')
        self._clock = VirtualClock(now_s, 'run on')  # the state is of another machine
        cell = as_observed(_without_faults(cell), observed_s)
        state = _of_cell(plain_state['state'], digest(cell))
        gateway = _RunningRobots(cell, types, self._clock, state.get('setups_told', {}))
        store = _From(json.dumps({**plain_state, 'state': state}))
        self.orchestrator = Orchestrator(
            cell,
            gateway,
            self._clock,
            store,
            [self._log, *sinks],
            auto_resume=not _has_to_be_resumed(plain_state),
        )
        gateway.started_s = {
            task.goal: task.started for task in self.state.running.values() if task.goal
        }

    @property
    def state(self) -> CellState:
        """The state now."""
        return self.orchestrator.state

    def go_on(self, until: float) -> float:
        """Run on until every job has ended; return up to which moment all ends are known.

        It ends early at a cell that waits for a person, as that time is unknown.

        :param until: real time on the monotonic clock, at which it is given up
        """
        for job in self.state.jobs:
            self._leave_out(job, CYCLES_RUN)
        self.orchestrator.settle()
        while self.state.jobs and time.monotonic() < until:
            if not self._step():
                self._stuck = sentence('nothing_goes_on')
                return math.inf
            self._leave_out_what_repeats()
        late_s = sum(self._put_back_s(job) for job in self._log.ended_s)
        return self._clock.now() + late_s if self.state.jobs else math.inf

    def go_on_to_end_of(self, job: str) -> float | None:
        """Run on until a job has ended, however long it is, and return when that was.

        None: the run came to a cell that waits for a person, or where nothing can happen.
        """
        self.orchestrator.settle()
        while job not in self._log.ended_s and self._step():
            pass
        return self._log.ended_s.get(job)

    def ends_s(self, by_s: float = math.inf) -> dict[str, float]:
        """Return when each job ended, up to a moment; those unknown are left out.

        The time of the cycles that were left out is put back, of a job and of those in front.
        """
        late_s, ends = 0.0, {}
        for job, end_s in self._log.ended_s.items():
            late_s += self._put_back_s(job)
            ends[job] = end_s + late_s
        return {job: end_s for job, end_s in ends.items() if end_s <= by_s}

    def _put_back_s(self, job: str) -> float:
        return self._left_out.get(job, 0) * self._log.pace_s(job)

    @property
    def changeover_s(self) -> float:
        """Seconds of all changes of setups between jobs, of all components together."""
        return self._log.changeover_s

    def unknown(self, job: str) -> str:
        """Say why a job has not ended where the run came to; empty: it has."""
        live = self.state.jobs.get(job)
        if live is None:
            return ''
        return Unknown(self.state, None).why(live) or self._stuck

    def close(self) -> None:
        """Give the engine up."""
        self.orchestrator.close()

    def _step(self) -> bool:
        """Let the next things happen; tell whether there are any without a person."""
        if self.state.holds or not self._clock.advance():
            return False
        self.orchestrator.settle()
        self.steps += 1
        return True

    def _leave_out_what_repeats(self) -> None:
        """Leave out periods of the only job on the line, once it stands as it has stood before.

        Engine and virtual robots would do the same again. Only a script whose conditions ask for
        the number of an item is run whole.
        """
        name = next(iter(self.state.jobs.line), '')
        packed_s = self._log.packed_s[name]
        is_packed = packed_s[-1:] == [self._clock.now()]
        if not is_packed or name in self._log.repeating_s or len(self.state.jobs.line) > 1:
            return
        before = self._stood.setdefault(_standing(self.state, name, packed_s[-1]), len(packed_s))
        period = len(packed_s) - before
        if period and not _tells_items_apart(self.state.script(name)):
            self._log.repeating_s[name] = (packed_s[-1] - packed_s[before - 1]) / period
            self._leave_out(name, CYCLES_KEPT, period)

    def _leave_out(self, name: str, kept: int, period: int = 1) -> None:
        """Leave out whole periods of a job; about so many cycles to begin are kept."""
        job = self.state.jobs[name]
        more = (job.cycles_left - kept) // period * period
        if more > 0:
            self._left_out[name] = self._left_out.get(name, 0) + more
            job.job = replace(job.job, quantity=job.job.quantity - more)


def _tells_items_apart(script: Script) -> bool:
    """Tell whether a condition asks for the number of an item, or for its order."""
    return any(
        reference.source in ('item', 'order')
        for task in script.tasks.values()
        for condition in task.comparisons
        for reference in condition.references
    )


def _standing(state: CellState, name: str, now_s: float) -> Hashable:
    """Return all that decides what the line does next, without the names of items and the time.

    :param name: the only job on the line
    """
    begun = state.jobs[name].progress.started

    def place(item: str | None) -> Hashable:
        if item is None or item not in state.items:
            return None
        known = state.items[item]
        return begun - known.number, known.present, known.rejected

    def cycle(now: Cycle) -> Hashable:
        return place(now.item), state.beat - now.beat, *now.rounds.items()

    return (
        name,
        state.indexing,
        tuple(flag.count for flag in state.flags.values()),
        tuple(reading.ready for reading in state.readings.values()),
        tuple(len(count.rejects) for count in state.reject_counts.values()),
        tuple(
            (
                place(section.slot),
                state.beat - section.turn_beat,
                section.cycle and cycle(section.cycle),
            )
            for section in state.sections.values()
        ),
        frozenset(
            (
                key.section,
                place(key.item),
                key.task,
                task.phase,
                task.attempt,
                task.phase is Phase.RUNNING and round(now_s - task.started, DECIMALS),
                task.phase is Phase.RETRYING and round(task.not_before - now_s, DECIMALS),
            )
            for key, task in state.tasks.items()
        ),
    )


def _of_cell(state: Mapping[str, Any], now: str) -> dict[str, Any]:
    """Return a state as that of a cell with another digest; what was released stays so.

    The servers that made the setups are others than the virtual ones, so they are left out.
    """
    before = state.get('cell_digest', '')
    released = {
        script: [now] for script, cells in state.get('released', {}).items() if before in cells
    }
    return {
        **state,
        'cell_digest': now,
        'released': released,
        'setups': {
            component: {setup: {'value': entry['value']} for setup, entry in setups.items()}
            for component, setups in state.get('setups', {}).items()
        },
    }


def _has_to_be_resumed(plain_state: Mapping[str, Any]) -> bool:
    """Tell whether an operator has to check the line first, after a restart."""
    holds = plain_state['state'].get('holds', {})
    return any(hold.get('reason') == RESTARTED for hold in holds.values())


def _without_faults(cell: Cell) -> Cell:
    components = {
        name: replace(component, faults=()) for name, component in cell.components.items()
    }
    conveyor = replace(cell.conveyor, component=components[cell.conveyor.component.name])
    piece = Approval.AUTOMATIC  # taken as approved
    return replace(cell, conveyor=conveyor, components=components, first_piece=piece)


class _Log:
    """When items were packed and jobs ended. Implements `ports.EventSink`."""

    def __init__(self, cell: Cell) -> None:
        self._cell = cell
        self._changes_s: dict[e.TaskKey, float] = {}
        """When the changes of setups began that go on."""
        self.changeover_s = 0.0
        self.packed_s: dict[str, list[float]] = defaultdict(list)
        self.repeating_s: dict[str, float] = {}
        """Seconds between two items, of jobs with which the line repeats itself."""
        self.ended_s: dict[str, float] = {}

    def publish(self, events: Sequence[e.Event]) -> None:
        """Note what matters."""
        for event in events:
            if isinstance(event, e.ItemRemoved):
                self.packed_s[event.job].append(event.time)
            elif isinstance(event, e.JobCompleted | e.JobAborted):
                self.ended_s[event.job] = event.time
            elif isinstance(event, e.TaskEvent) and event.section is None:
                self._note_change(event)

    def _note_change(self, event: e.TaskEvent) -> None:
        """Add the time of a change before the first task of a job (semantics 5.3)."""
        if isinstance(event, e.TaskStarted):
            setups = self._cell.components[event.component].setups.values()
            if any(setup.task == event.name for setup in setups):
                self._changes_s[event.key] = event.time
        elif isinstance(event, e.TaskSucceeded | e.TaskFailed) and event.key in self._changes_s:
            self.changeover_s += event.time - self._changes_s.pop(event.key)

    def pace_s(self, job: str) -> float:
        """Return the seconds between two items, where the line neither fills nor drains."""
        if job in self.repeating_s:
            return self.repeating_s[job]
        times = self.packed_s[job]
        edge = len(times) // 4
        middle = times[edge : len(times) - edge]
        return (middle[-1] - middle[0]) / (len(middle) - 1) if len(middle) > 1 else 0.0


class _RunningRobots(VirtualGateway):
    """Robots that are in the middle of the goals they are asked about."""

    def __init__(
        self,
        cell: Cell,
        types: ActionTypes,
        clock: VirtualClock,
        setups: Mapping[str, Mapping[str, str]],
    ) -> None:
        self.started_s: dict[str, float] = {}
        self._now = clock.now
        super().__init__(cell, types, clock, duration=self._left_s, setups=setups)

    def adopt(self, request: GoalRequest) -> VirtualGoal:
        """Go on with a goal, as if it were known."""
        return self.send(request)

    def _left_s(self, request: GoalRequest) -> float:
        whole_s = self._nominal_s(request)
        started_s = self.started_s.pop(request.id, None)
        if started_s is None:
            return whole_s
        return min(max(0.0, started_s + whole_s - self._now()), whole_s)  # a clock may be set


class _From:
    """A journal that begins with a state, and keeps nothing. Implements `ports.EventStore`."""

    def __init__(self, state: str) -> None:
        self._state = state

    at_disk: Callable[[], None]
    history = ''
    is_restored = False
    epoch = 0

    def missing(self, after: int) -> str:  # noqa: ARG002 - the port's
        """Return nothing: the state is whole."""
        return ''

    def go_on_after(self, seq: int) -> None:
        """Do nothing: nothing is missing."""

    def append(self, events: Sequence[e.Event]) -> None:
        """Keep nothing: no run will continue from here."""

    def read(self, after: int = 0, most: int = -1) -> Sequence[e.Event]:  # noqa: ARG002 - the port's
        """Return nothing: there are no events besides the state."""
        return ()

    def first_seq(self) -> int:
        """Return 1; it is not used."""
        return 1

    def snapshots(self) -> Sequence[Snapshot]:
        """Return nothing: there is nothing to replay."""
        return ()

    def beginning(self) -> Snapshot:
        """Return that state."""
        return Snapshot(0, '', self._state)

    def used_ids(self, digest: str) -> str:  # noqa: ARG002 - the port's
        """Return an empty part: what was used before the state is no matter of a forecast."""
        return text_of((), {})

    def may_command(self) -> bool:
        """Return True: its goals are virtual."""
        return True

    def absent_at(self, seq: int) -> None:
        """Return no moment: no goal is asked for."""


# Forecasts when jobs of a running cell end: runs the real engine on from the present state.
#
# A cell that waits for an answer, or was stopped, gets no forecast: the time until it continues
# is unknown.


def expected_ends(
    cell: Cell,
    types: ActionTypes,
    plain_state: Mapping[str, Any],
    observed_s: Mapping[str, Mapping[str, float]],
    now_s: float,
) -> dict[str, float]:
    """Return when each live job will end, on the clock of `now_s`; those unknown are left out.

    :param plain_state: of `model.keeping.snapshot`
    :param observed_s: seconds that tasks took, by component and task constant
    """
    until = time.monotonic() + LONGEST_S
    with closing(RunOn(cell, types, plain_state, observed_s, now_s)) as run:
        run.go_on(until)
        return run.ends_s()
