"""The status of a cell, read from its engine: the only source of the facts for clients."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

from bt_orchestrator.engine.runtime.job_overview import (
    TasksInFlight,
    Unknown,
    feedback_of,
    job_status,
)
from bt_orchestrator.engine.runtime.observed_durations import ObservedDurations
from bt_orchestrator.engine.runtime.permits.manual import goal_of
from bt_orchestrator.engine.runtime.stands import Engine, Standstill
from bt_orchestrator.model.action_type import TASK
from bt_orchestrator.model.by import Role
from bt_orchestrator.model.cell import Cell, Component
from bt_orchestrator.model.goal import Contest
from bt_orchestrator.model.jobs.setups import known
from bt_orchestrator.model.limits import ENDED_SHOWN, QUEUE_SHOWN
from bt_orchestrator.model.packml import UnitMode
from bt_orchestrator.model.requests import Request, of_cell
from bt_orchestrator.model.state import CellState, Finished, ItemState, JobState, SectionState
from bt_orchestrator.model.status import (
    BeltStatus,
    CellDescription,
    CellStatus,
    ComponentDescription,
    ComponentStatus,
    FinishedCycle,
    FlagStatus,
    ItemStatus,
    JobStatus,
    Leadership,
    SectionStatus,
)
from bt_orchestrator.model.stop_reason import StopReason, way_to_work
from bt_orchestrator.model.task_spans import passed_tasks
from bt_orchestrator.model.uptime import Uptime
from bt_orchestrator.model.wait import BELT, INITIALIZATION, PartWait, Wait
from bt_orchestrator.model.waits.waiting import by_part, together
from bt_orchestrator.model.words import Words, facts_of
from bt_orchestrator.ports import ActionTypes

_NO_ENDS: Mapping[str, float] = {}


class RosAccess(NamedTuple):
    """The terms on which a node takes requests over ROS."""

    role: Role
    """Of all clients that do not sign."""
    signed_commands: str
    """optional or required (semantics 7.12)."""
    uptime: Callable[[], Uptime]
    """By it the node tells old signatures from new ones."""

    def facts(self) -> dict[str, Any]:
        """Return the fields of a status about it."""
        boot, seconds = self.uptime()
        facts = {'signed_commands': self.signed_commands, 'boot': boot, 'uptime': seconds}
        return {'unauthenticated_role': self.role, **facts}


class Overview:
    """Reads a cell from outside; changes nothing."""

    def __init__(
        self,
        engine: Engine,
        durations: ObservedDurations | None = None,
        access: RosAccess | None = None,
        leadership: Callable[[], Leadership | None] = lambda: None,
    ) -> None:
        """Prepare to read a cell.

        :param durations: how long tasks took; None: only the nominal durations are known
        :param access: None: there is no access over ROS
        :param leadership: returns who leads and who stands by; None: no other node can take over
        """
        self._engine = engine
        self._access = access
        self._leadership = leadership
        self._durations = durations or ObservedDurations()
        self._standstill = Standstill(engine)

    def status(
        self,
        now_s: float,
        ends_s: Mapping[str, float] = _NO_ENDS,
        *,
        until_s: float | None = None,
        rest_s: float | None = None,
    ) -> CellStatus:
        """Return the status of the cell.

        :param ends_s: in how many seconds jobs are expected to end
        :param until_s: of a past moment: until when nothing changed; None: now
        :param rest_s: of a past moment: since when nothing changed; None: since the last event
        """
        engine = self._engine
        state, waits = engine.state, self._waits()
        in_flight = self._in_flight()
        until_s = now_s if until_s is None else until_s
        stands = self._standstill.look(until_s, self.waits, rest_s)
        unknown = Unknown(state, stands)
        jobs = (*state.jobs.first(QUEUE_SHOWN), *list(state.ended.values())[-ENDED_SHOWN:])
        return CellStatus(
            cell=state.cell.name,
            stamp=now_s,
            seq=state.seq,
            history=state.history,
            state=state.packml,
            state_since=state.packml_since,
            state_times=state.times(now_s),
            stop_reason=state.stop_reason,
            stop_message=state.stop_message,
            stop_words=_stop_words(state),
            stands=stands,
            stop_after=state.stop_after or '',
            wish=state.wish,
            waits_for=_waits_for(state),
            safety=_safety(state),
            safety_words=_facts(state.unsafe),
            control=state.control,
            unit_mode=state.unit_mode,
            manual=goal_of(state),
            **(self._access.facts() if self._access else {}),
            commands=tuple(request.word for request in self._possible()),
            journal_failure=engine.broken or '',
            disk_wait=engine.disk_wait,
            belt=BeltStatus(state.indexing, in_flight.of_belt(), waits[BELT]),
            initialization=waits[INITIALIZATION],
            sections=tuple(
                section_status(state, section, in_flight, waits[number])
                for number, section in state.sections.items()
            ),
            components=tuple(self.components()),
            jobs=tuple(job_status(state, job, in_flight, ends_s, unknown) for job in jobs),
            queued=state.jobs.waiting,
            flags=tuple(
                FlagStatus(name, flag.count, flag.capacity) for name, flag in state.flags.items()
            ),
            holds=tuple(state.holds.values()),
            leadership=self._leadership(),
        )

    def job(self, job: JobState, ends_s: Mapping[str, float] = _NO_ENDS) -> JobStatus:
        """Return the status of a job, live or ended.

        :param ends_s: in how many seconds jobs are expected to end
        """
        unknown = Unknown(self._engine.state, self._standstill.told)
        return job_status(self._engine.state, job, self._in_flight(), ends_s, unknown)

    def components(self) -> Iterator[ComponentStatus]:
        """Yield the status of the components; also after the journal has failed."""
        for component in self._engine.state.cell.components.values():
            yield self._component(component)

    def waits(self) -> list[PartWait]:
        """Return who waits for what, in the order of the belt (semantics 7.4)."""
        return [
            PartWait(f'section {part}', wait, part)
            if isinstance(part, int)
            else PartWait(part, wait)
            for part, waits in self._waits().items()
            for wait in waits
        ]

    def _waits(self) -> Mapping[str | int, tuple[Wait, ...]]:
        seen = self._engine.tree.recorder
        parts = by_part(seen.state, seen)
        return {part: together(waits) for part, waits in parts.items()}

    def _in_flight(self) -> TasksInFlight:
        return TasksInFlight(self._engine, self._durations)

    def _possible(self) -> tuple[Request, ...]:
        """Return the commands that are possible; without a journal only to cancel the goals."""
        state = self._engine.state
        return of_cell(state.packml, state.unit_mode, is_broken=bool(self._engine.broken))

    def _component(self, component: Component) -> ComponentStatus:
        engine, name = self._engine, component.name
        state = engine.state
        key = state.reserved.get(name)
        progress = state.tasks.get(key) if key else None
        reading = state.readings[name]
        contested = self._contested(component)
        out = state.out_of_service.get(name)
        return ComponentStatus(
            name=name,
            action=component.action,
            available=engine.gateway.available(name),
            ready=reading.ready and not contested and out is None,
            out_of_service='' if out is None else out.reason,
            out_of_service_since=None if out is None else out.since,
            contested=contested.words(component.action) if contested else '',
            contested_words=contested.facts(component.action) if contested else None,
            state='' if reading.value is None else str(reading.value),
            setups={setup: known(state, name, setup) or '' for setup in component.setups},
            task=str(key) if key else '',
            feedback=feedback_of(engine.flights, progress.goal if progress else None),
        )

    def _contested(self, component: Component) -> Contest | None:
        """Return who else uses or serves a component; also after the journal has failed."""
        rivals = self._engine.gateway.rivals(component.name)
        contests = self._engine.state.contests
        return Contest(tuple(rivals)) if rivals else contests.get(component.name)


def _stop_words(state: CellState) -> Words | None:
    """Return the stop reason as facts; None: it is known in words only."""
    by_hold = state.stop_reason in (StopReason.OPERATOR, StopReason.OWN_FAULT)
    if state.holds and by_hold:
        return Words('hold', {'hold': next(iter(state.holds))})
    return _facts(state.stop_message)


def _facts(message: str) -> Words | None:
    """Return what a message of one sentence says; None: it is known in words only."""
    facts = facts_of(message)
    return facts[0] if len(facts) == 1 else None


def description_of(cell: Cell, types: ActionTypes) -> CellDescription:
    """Return the parts of a cell."""
    return CellDescription(
        cell=cell.name,
        sections=cell.conveyor.sections,
        conveyor=cell.conveyor.component.name,
        components=tuple(
            ComponentDescription(
                name=component.name,
                action=component.action,
                type=component.type,
                sections=component.sections,
                durations_s=component.durations_s,
                default_duration_s=component.default_duration_s,
                tasks=tuple(type_.constants) if type_.has_task_field else (),
                goal_fields={
                    name: field.ros_name
                    for name, field in type_.goal.fields.items()
                    if name != TASK
                },
            )
            for component in cell.components.values()
            for type_ in (types.action(component.type),)
        ),
    )


# The status of a section: its slot, its current cycle, and what it finished in this beat.


def section_status(
    state: CellState, section: SectionState, in_flight: TasksInFlight, waits: tuple[Wait, ...]
) -> SectionStatus:
    """Return the status of a section.

    :param waits: why it waits
    """
    slot, cycle = state.slot(section.number), section.cycle
    finished = section.finished if state.belt_carries else None
    passed, failed = passed_tasks(state, section.number, cycle) if cycle else ((), ())
    return SectionStatus(
        number=section.number,
        slot=None if slot is None else _item(slot),
        job=cycle.job if cycle else '',
        item=_item(state.items[cycle.item]) if cycle else None,
        running=in_flight.of_section(section.number),
        passed=passed,
        failed=failed,
        waits=waits,
        finished=_finished(finished) if finished else None,
    )


def _item(item: ItemState) -> ItemStatus:
    return ItemStatus(item.id, item.present, item.rejected, tuple(item.nonconforming))


def _finished(finished: Finished) -> FinishedCycle:
    return FinishedCycle(finished.job, finished.item, finished.passed, finished.failed)


def _waits_for(state: CellState) -> str:
    """Return the commands that the cell waits for; empty: for none."""
    if state.unit_mode is UnitMode.MANUAL:
        return f'{UnitMode.PRODUCTION.value}, {way_to_work(state.packml)}'
    return way_to_work(state.packml) if state.stopped_by is not None else ''


def _safety(state: CellState) -> str:
    return state.unsafe or ('' if state.cell.safety is None else 'ready')
