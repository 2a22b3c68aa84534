"""A journal that cannot be written: nothing is sent, and goals can still be cancelled (9.1)."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Sequence

import pytest
from fakes.action_types import FakeActionTypes
from fakes.commands import Abort, CellCommand, Pause, RemoveItem, Reset, Resume, Start, Stop
from fakes.line import Line, with_section
from fakes.operator import ann

from bt_orchestrator.base.errors import JournalFailed
from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.model import events as e
from bt_orchestrator.model.by import By, Role
from bt_orchestrator.model.commands import Answer, Shutdown
from bt_orchestrator.model.goal import GoalRequest, GoalStatus
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.stop_reason import StopReason
from bt_orchestrator.sim.gateway import VirtualClock, VirtualGateway
from bt_orchestrator.sim.virtual_client import VirtualGoal
from bt_orchestrator.store.memory import MemoryStore

TYPES = FakeActionTypes()
NOT_ON_RECORD = 'this is not on record: the journal x.sqlite3 cannot be written: disk full'
IN_PARALLEL = with_section(2, '- parallel: [{id: work, @a2%s}, {id: look, @b2}]')


class Disk(MemoryStore):
    """A journal whose disk becomes full."""

    is_full = False

    def append(self, events: Sequence[e.Event]) -> None:
        if self.is_full:
            raise JournalFailed('the journal x.sqlite3 cannot be written: disk full')
        super().append(events)


class WatchedGateway(VirtualGateway):
    """Controllers that note which goals they got, and how often somebody asked to cancel each."""

    def __init__(self, line: Line, clock: VirtualClock) -> None:
        super().__init__(line.cell, TYPES, clock)
        self.goals: dict[str, VirtualGoal] = {}
        self.cancels: Counter[str] = Counter()

    def send(self, request: GoalRequest) -> VirtualGoal:
        goal = super().send(request)
        passed_on = goal._cancel

        def cancel(goal: VirtualGoal) -> None:
            self.cancels[goal.request.id] += 1
            passed_on(goal)

        goal._cancel = cancel
        self.goals[request.id] = goal
        return goal

    @property
    def open(self) -> list[str]:
        return [uuid for uuid, goal in self.goals.items() if goal.end is None]

    def ended(self, uuids: Sequence[str]) -> set[GoalStatus | None]:
        ends = (self.goals[uuid].end for uuid in uuids)
        return {end.status if end else None for end in ends}


class Plant:
    """A line at work, its controllers, and a disk that may become full."""

    def __init__(self, *, fault: str = '', options: str = '') -> None:
        """Run until both components of section 2 are at work, with 5 s to go.

        :param fault: of one of them, whose task has the options
        """
        self.line = Line(seconds={'a2': 5.0, 'b2': 5.0}, faults={'a2': fault} if fault else {})
        self.clock = VirtualClock()
        self.gateway = WatchedGateway(self.line, self.clock)
        self.disk = Disk()
        self._ids = (f'00000000-0000-4000-8000-{n:012d}' for n in itertools.count(1))
        self.start()
        script = self.line.script(IN_PARALLEL % options)
        assert self.orchestrator.ask(AddJobs((Job('J', script, 1),))).accepted
        while {key.task for key in self.orchestrator.state.running} != {'work', 'look'}:
            self.advance()
        self.advance()  # the requests reach their servers

    def start(self) -> None:
        self.orchestrator = Orchestrator(
            self.line.cell,
            self.gateway,
            self.clock,
            self.disk,
            new_goal_id=lambda: next(self._ids),
        )

    def advance(self) -> None:
        assert self.clock.advance()
        self.orchestrator.settle()

    def go(self, until: float) -> None:
        self.clock.call_at(until, lambda: None)
        while self.clock.now() < until:
            self.advance()

    def fill_disk(self) -> None:
        """Fill the disk; a command that is lost tells the orchestrator."""
        self.disk.is_full = True
        assert not self.orchestrator.ask(Pause(ann())).accepted

    def awaits_ends(self) -> bool:
        return self.orchestrator.awaits_ends

    def abort(self) -> Answer:
        return self.orchestrator.ask(Abort(ann('smoke')))


def test_9_1_without_a_journal_abort_cancels_every_goal() -> None:
    plant = Plant()
    plant.fill_disk()
    kept, running = list(plant.disk.read()), plant.gateway.open
    assert len(running) == 2

    answer = plant.abort()
    assert answer.accepted
    assert answer.message.startswith(f'2 goals are being cancelled; {NOT_ON_RECORD}')
    plant.advance()
    assert plant.gateway.ended(running) == {GoalStatus.CANCELED}
    assert list(plant.disk.read()) == kept


@pytest.mark.parametrize('is_known', [True, False])
def test_7_9_safety_loss_without_journal_cancels_goals_once(is_known: bool) -> None:
    plant = Plant()
    running = plant.gateway.open
    if is_known:
        plant.fill_disk()
    plant.disk.is_full = True  # or else the record of the loss is the first that fails
    for unsafe in ('its value is False', 'no message for 0.5 s'):
        plant.gateway.say_of_safety(unsafe)
        plant.orchestrator.settle()
    assert plant.orchestrator.broken
    assert {uuid: plant.gateway.cancels[uuid] for uuid in running} == dict.fromkeys(running, 1)
    plant.advance()
    assert plant.gateway.ended(running) == {GoalStatus.CANCELED}


def test_7_1_unauthorized_abort_cancels_nothing() -> None:
    plant = Plant()
    plant.fill_disk()
    answer = plant.orchestrator.ask(Abort(By('Eve', '', 'a try', Role.VIEW)))
    assert (answer.accepted, 'cell.abort is for the role' in answer.message) == (False, True)
    assert not plant.gateway.cancels


def test_9_1_status_never_claims_abort_is_recorded() -> None:
    plant = Plant()
    plant.fill_disk()
    broken = plant.orchestrator.broken or ''
    assert 'what runs goes on to its end unless abort cancels it' in broken
    plant.abort()
    broken = plant.orchestrator.broken or ''
    assert '2 asked to cancel without a record, 2 of them not ended' in broken
    plant.advance()
    broken = plant.orchestrator.broken or ''
    assert '2 asked to cancel without a record, 0 of them not ended' in broken
    state = plant.orchestrator.state
    assert (state.packml, state.stop_reason) == (PackmlState.HELD, StopReason.OWN_FAULT)
    assert 'disk full' in state.stop_message
    assert state.wish is None
    assert state.seq == len(list(plant.disk.read()))


def test_9_1_unrecordable_abort_still_cancels_goals() -> None:
    plant = Plant()
    running = plant.gateway.open
    plant.disk.is_full = True
    answer = plant.abort()
    assert answer.accepted
    assert answer.message.startswith(f'2 goals are being cancelled; {NOT_ON_RECORD}')
    plant.advance()
    assert plant.gateway.ended(running) == {GoalStatus.CANCELED}
    assert plant.orchestrator.state.packml is PackmlState.HELD


def test_9_1_repeated_abort_on_full_disk_cancels_again() -> None:
    plant = Plant(fault='=ignore_cancel')
    assert plant.abort().accepted
    (stubborn,) = [u for u in plant.gateway.open if plant.gateway.cancels[u]][:1]
    plant.disk.is_full = True
    assert plant.abort().accepted  # Aborting: with a journal it is refused
    assert plant.gateway.cancels[stubborn] == 2


def test_9_1_abort_again_cancels_again() -> None:
    plant = Plant(fault='=ignore_cancel')
    plant.fill_disk()
    plant.abort()
    plant.advance()
    (stubborn,) = plant.gateway.open
    assert plant.gateway.cancels[stubborn] == 1
    assert plant.abort().message.startswith('1 goal is being cancelled')
    assert plant.gateway.cancels[stubborn] == 2
    assert '2 asked to cancel without a record, 1 of them' in (plant.orchestrator.broken or '')


@pytest.mark.parametrize('command', [Pause, Resume, Stop, Reset, Start])
def test_9_1_every_other_command_is_refused_and_says_why(command: CellCommand) -> None:
    plant = Plant()
    plant.fill_disk()
    for refused in (command(ann()), RemoveItem('J/1', ann())):
        answer = plant.orchestrator.ask(refused)
        assert (answer.accepted, answer.message) == (False, plant.orchestrator.broken)
    assert 'disk full; nothing is sent any more' in (plant.orchestrator.broken or '')
    assert not plant.gateway.cancels


def test_9_1_what_ends_meanwhile_is_known() -> None:
    plant = Plant()
    plant.fill_disk()
    assert plant.awaits_ends()
    plant.go(until=20.0)
    assert not plant.awaits_ends()
    assert plant.abort().message.startswith('0 goals are being cancelled')
    assert not plant.gateway.cancels


def test_9_1_goal_end_that_breaks_journal_is_known() -> None:
    plant = Plant()
    plant.disk.is_full = True
    plant.go(until=20.0)
    assert plant.orchestrator.broken
    assert plant.orchestrator.state.running  # as far as anything is on record
    assert not plant.awaits_ends()


def test_9_1_abandoned_goal_is_cancelled_too() -> None:
    plant = Plant(fault='=ignore_cancel', options=', timeout: 2')
    plant.go(until=30.0)
    assert [hold.reason for hold in plant.orchestrator.state.holds.values()] == ['in_doubt']
    (given_up,) = plant.gateway.open
    plant.fill_disk()
    assert plant.abort().message.startswith('1 goal is being cancelled')
    assert plant.gateway.cancels[given_up] == 2  # the first one was the timeout's


def test_9_1_start_on_full_disk_can_cancel_goals() -> None:
    plant = Plant()
    running = plant.gateway.open
    plant.orchestrator.close()
    plant.disk.is_full = True
    plant.start()
    plant.orchestrator.settle()
    assert plant.orchestrator.broken
    assert plant.abort().message.startswith('2 goals are being cancelled')
    plant.advance()
    assert plant.gateway.ended(running) == {GoalStatus.CANCELED}


def test_9_1_next_orchestrator_holds_goals_cancelled_off_record() -> None:
    plant = Plant(options=', retries: 2')
    plant.fill_disk()
    plant.abort()
    plant.advance()
    plant.orchestrator.close()
    plant.disk.is_full = False
    plant.start()
    plant.orchestrator.settle()
    plant.go(until=plant.clock.now() + 10.0)
    holds = plant.orchestrator.state.holds.values()
    assert sorted((hold.reason, hold.task) for hold in holds) == [
        ('in_doubt', 'look'),
        ('in_doubt', 'work'),
        ('restarted', None),
    ]
    assert not plant.gateway.open
    assert plant.abort().message == '0 goals are being cancelled'
    assert plant.orchestrator.state.packml in (PackmlState.ABORTING, PackmlState.ABORTED)


def test_9_1_shutdown_without_journal_cancels_and_awaits_goals() -> None:
    plant = Plant()
    plant.fill_disk()
    running = plant.gateway.open
    assert plant.orchestrator.ask(Shutdown()).accepted
    assert [plant.gateway.cancels[uuid] for uuid in running] == [1, 1]
    assert plant.awaits_ends()
    plant.advance()
    assert not plant.awaits_ends()


def test_9_1_shutdown_names_goals_that_ignore_cancel() -> None:
    plant = Plant(fault='=ignore_cancel')
    plant.fill_disk()
    plant.orchestrator.ask(Shutdown())
    plant.advance()
    (stubborn,) = plant.gateway.open
    assert plant.awaits_ends()
    assert plant.orchestrator.breakdown
    assert plant.orchestrator.breakdown.in_flight == [f'work of J/1 (goal {stubborn})']
