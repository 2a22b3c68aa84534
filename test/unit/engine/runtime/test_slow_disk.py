"""A commit that takes its time: the thread is free, and nothing goes before it (semantics 9.1)."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable, Sequence
from queue import SimpleQueue

import pytest
from fakes.action_types import FakeActionTypes
from fakes.board import shown
from fakes.commands import Abort, Pause, Resume
from fakes.held_writer import HeldWriter
from fakes.line import Line, with_section
from fakes.operator import ann

from bt_orchestrator.base.errors import JournalFailed, JournalUnusable
from bt_orchestrator.base.replies import Reply, begin
from bt_orchestrator.engine.runtime.commits import PATIENCE_S
from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.engine.runtime.writers import MOST_READINGS, Readings, WriterThread
from bt_orchestrator.model import events as e
from bt_orchestrator.model.by import By, Role
from bt_orchestrator.model.commands import Answer, Command, Shutdown
from bt_orchestrator.model.goal import GoalRequest, GoalStatus
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.sim.gateway import VirtualClock, VirtualGateway
from bt_orchestrator.sim.virtual_client import VirtualGoal
from bt_orchestrator.store.memory import MemoryStore

TYPES = FakeActionTypes()
WORK = with_section(2, '- {id: work, @a2%s}')


class Disk(MemoryStore):
    """A journal whose disk may fail."""

    failure: Exception | None = None

    def append(self, events: Sequence[e.Event]) -> None:
        if self.failure is not None:
            raise self.failure
        super().append(events)


class Gateway(VirtualGateway):
    """Controllers that note which goals they got."""

    def __init__(self, line: Line, clock: VirtualClock) -> None:
        super().__init__(line.cell, TYPES, clock)
        self.goals: list[VirtualGoal] = []
        self.prepared: list[GoalRequest] = []

    def prepare(self, request: GoalRequest) -> None:
        self.prepared.append(request)

    def send(self, request: GoalRequest) -> VirtualGoal:
        self.goals.append(super().send(request))
        return self.goals[-1]


class Plant:
    """A line whose disk is slow when it is told to; section 2 works for 5 s."""

    def __init__(self, options: str = '', fault: str = '') -> None:
        self.line = Line(seconds={'a2': 5.0}, faults={'a2': fault} if fault else {})
        self.clock = VirtualClock()
        self.gateway = Gateway(self.line, self.clock)
        self.disk, self.writer = Disk(), HeldWriter()
        self.told: list[e.Event] = []
        ids = (f'00000000-0000-4000-8000-{n:012d}' for n in itertools.count(1))
        self.orchestrator = Orchestrator(
            self.line.cell,
            self.gateway,
            self.clock,
            self.disk,
            [self],
            writer=self.writer,
            new_goal_id=lambda: next(ids),
        )
        self.orchestrator.settle()
        self.script = self.line.script(WORK % options)

    def publish(self, events: Sequence[e.Event]) -> None:
        self.told.extend(events)

    def put(self, command: Command) -> Reply[Answer]:
        return begin(self.orchestrator.carry_out(command))

    def order(self, name: str = 'J') -> Reply[Answer]:
        return self.put(AddJobs((Job(name, self.script, 1),)))

    def until_working(self) -> VirtualGoal:
        """Run until `work` is under way at its server."""
        assert self.order().value.accepted
        while 'work' not in {key.task for key in self.orchestrator.state.running}:
            self.advance()
        self.advance()
        return self.gateway.goals[-1]

    @property
    def why_broken(self) -> str:
        return self.orchestrator.broken or ''

    def advance(self) -> None:
        assert self.clock.advance()
        self.orchestrator.settle()

    def pass_time(self, seconds: float) -> None:
        until = self.clock.now() + seconds
        self.clock.call_at(until, lambda: None)
        while self.clock.now() < until:
            self.advance()

    def disk_answers(self) -> None:
        """Let the disk take what is written, again and again until nothing waits for it."""
        while self.writer.held:
            self.writer.release()
            self.orchestrator.settle()


def slow(plant: Plant) -> Plant:
    plant.writer.is_slow = True
    return plant


def test_9_1_nothing_goes_before_its_commit_has_ended() -> None:
    plant = slow(Plant())
    event_count, kept = len(plant.told), plant.orchestrator.kept_seq
    board = f'{plant.orchestrator._projection.space}/'
    before = shown(board)
    answer = plant.order()
    for _ in range(3):
        assert not plant.orchestrator.settle()
        assert not plant.gateway.goals
        assert not answer.is_there
        assert len(plant.told) == event_count
        assert plant.orchestrator.kept_seq == kept == len(list(plant.disk.read()))
    assert shown(board) == before
    assert len(plant.gateway.prepared) == 1, 'once, while the disk works'
    assert plant.orchestrator.state.seq > kept
    assert 'the disk has not taken the last' in plant.orchestrator.disk_wait
    plant.disk_answers()
    assert answer.value.accepted
    assert shown(board) != before
    assert [goal.request for goal in plant.gateway.goals] == plant.gateway.prepared
    assert not plant.orchestrator.disk_wait
    assert [event.seq for event in plant.told] == [event.seq for event in plant.disk.read()]
    assert plant.orchestrator.kept_seq == plant.orchestrator.state.seq


def test_commands_wait_and_keep_their_order() -> None:
    plant = slow(Plant())
    first = plant.order('J')
    paused, again, resumed = plant.put(Pause(ann())), plant.order('J'), plant.put(Resume(ann()))
    plant.writer.release()
    plant.orchestrator.settle()
    assert first.is_there
    assert not paused.is_there  # decided now, and waits for a commit of its own
    assert not again.is_there
    plant.disk_answers()
    assert paused.value.accepted
    assert 'was given before' in again.value.message
    assert resumed.value.accepted
    assert list(plant.orchestrator.state.jobs) == ['J']


def test_others_are_served_between_waiting_commands(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """An answer to a client that has gone takes 0.1 s: nobody was heard while all were given."""
    plant, passed = slow(Plant()), [0.0]
    monkeypatch.setattr(plant.clock, 'steady', lambda: passed[0])
    plant.order('J')

    def answered(_: Answer) -> None:
        passed[0] += 0.1

    waiting = [plant.order('J') for _ in range(5)]
    for answer in waiting:
        answer.then(answered)
    plant.writer.is_slow = False
    plant.writer.release()
    given = []
    for _ in range(4):
        plant.orchestrator.settle()
        given.append(sum(answer.is_there for answer in waiting))
    assert given == [1, 2, 3, 4]
    last = plant.put(Pause(ann()))
    both = [answer.is_there for answer in (waiting[-1], last)]
    assert both == [False, False], 'it overtakes one that came before'
    plant.orchestrator.settle()
    plant.orchestrator.settle()
    assert all(answer.is_there for answer in (*waiting, last))


def test_9_1_waiting_commands_learn_of_broken_journal(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    plant, passed = slow(Plant()), [0.0]
    monkeypatch.setattr(plant.clock, 'steady', lambda: passed[0])
    plant.order('J')
    waiting = [plant.order('J') for _ in range(3)]
    for answer in waiting:
        answer.then(lambda _: passed.__setitem__(0, passed[0] + 0.1))
    plant.disk.failure = JournalFailed('broken')
    plant.writer.release()
    for _ in waiting:
        plant.orchestrator.settle()
    assert all('broken' in answer.value.message for answer in waiting)


def test_news_and_timeouts_are_handled_after_disk_wait() -> None:
    plant = Plant(options=', timeout: 3', fault='=hang')
    goal = plant.until_working()
    slow(plant).put(Pause(ann()))
    plant.pass_time(4.0)
    assert not goal.cancel_requested
    plant.disk_answers()
    plant.pass_time(1.0)
    plant.disk_answers()
    plant.pass_time(1.0)
    plant.disk_answers()
    failed = [event for event in plant.told if isinstance(event, e.TaskFailed)]
    assert [event.reason for event in failed] == ['timeout']


def test_9_1_disk_that_never_answers_breaks_journal() -> None:
    plant = Plant(fault='=hang')
    goal = plant.until_working()
    kept = list(plant.disk.read())
    pending, waiting = slow(plant).put(Pause(ann())), plant.put(Resume(ann()))
    plant.pass_time(PATIENCE_S - 1)
    assert plant.why_broken == ''
    plant.pass_time(2.0)
    assert 'has not taken the last' in plant.why_broken
    assert 'within 15 s' in plant.why_broken
    for refused in (pending, waiting):
        assert (refused.value.accepted, refused.value.message) == (
            False,
            plant.why_broken,
        )
    assert plant.orchestrator.state.seq == len(kept)
    assert not plant.orchestrator.disk_wait
    assert plant.put(Abort(ann())).value.message.startswith('1 goal is being cancelled')
    plant.advance()
    assert goal.end is not None
    plant.writer.release()  # it answers after all, and nobody listens any more
    plant.orchestrator.settle()
    assert plant.why_broken


@pytest.mark.parametrize(
    'failure', [JournalFailed('disk full'), OSError('gone'), ValueError('not to be written')]
)
def test_9_1_a_commit_that_fails_late_breaks_the_journal(failure: Exception) -> None:
    plant = Plant()
    plant.disk.failure = failure
    answer = slow(plant).order()
    plant.writer.release()
    assert plant.why_broken == ''
    plant.orchestrator.settle()
    assert str(failure.args[0]) in plant.why_broken
    assert not answer.value.accepted
    assert not plant.gateway.goals


@pytest.mark.parametrize('command', [Abort(ann('smoke')), Shutdown()])
def test_9_1_abort_and_shutdown_do_not_await_disk(command: Command) -> None:
    plant = Plant(fault='#1=hang')
    goal = plant.until_working()
    slow(plant).put(Pause(ann()))
    answer = plant.put(command)
    plant.advance()
    assert goal.end is not None
    assert goal.end.status is GoalStatus.CANCELED
    assert not answer.is_there
    assert not any(isinstance(event, e.TaskCancelRequested) for event in plant.told)
    plant.disk_answers()
    assert answer.value.accepted
    events = [
        event for event in plant.told if isinstance(event, (e.TaskCancelRequested, e.TaskFailed))
    ]
    assert isinstance(events[0], e.TaskCancelRequested)  # nobody else cancelled it
    assert 'cancelled by somebody else' not in str(events)


def test_7_9_safety_loss_cancels_goals_before_disk_answers() -> None:
    plant = Plant(fault='#1=hang')
    goal = plant.until_working()
    slow(plant).put(Pause(ann()))
    plant.gateway.say_of_safety('its value is False')
    plant.orchestrator.settle()
    plant.advance()
    assert goal.end is not None
    assert goal.end.status is GoalStatus.CANCELED
    assert not any(isinstance(event, e.SafetyChanged) for event in plant.told)
    plant.disk_answers()
    assert any(isinstance(event, e.SafetyChanged) for event in plant.told)
    assert plant.orchestrator.state.packml.value in ('Aborting', 'Aborted')


def test_7_1_unauthorized_abort_cancels_nothing() -> None:
    plant = Plant(fault='#1=hang')
    goal = plant.until_working()
    slow(plant).put(Pause(ann()))
    answer = plant.put(Abort(By('Eve', '', 'a try', Role.VIEW)))
    plant.advance()
    assert goal.end is None
    plant.disk_answers()
    assert not answer.value.accepted
    assert goal.end is None


def test_a_thread_waits_for_the_disk() -> None:
    line, clock, may_write = Line(), VirtualClock(), threading.Event()
    woken = threading.Event()

    class Stuck(MemoryStore):
        def append(self, events: Sequence[e.Event]) -> None:
            assert may_write.wait(60.0)
            super().append(events)

    writer, gateway = WriterThread(woken.set), Gateway(line, clock)
    may_write.set()
    orchestrator = Orchestrator(line.cell, gateway, clock, Stuck(), writer=writer)
    orchestrator.settle()
    may_write.clear()
    answer = begin(orchestrator.carry_out(AddJobs((Job('J', line.script(WORK % ''), 1),))))
    assert orchestrator.awaits_disk
    assert not answer.is_there
    woken.clear()
    may_write.set()
    assert woken.wait(60.0)
    orchestrator.settle()
    assert answer.value.accepted
    assert gateway.goals
    assert writer.close(60.0)
    orchestrator.close()


def test_goals_are_prepared_while_the_disk_works(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr('bt_orchestrator.engine.runtime.commits.AT_ONCE_S', 60.0)
    line, clock, may_write = Line(), VirtualClock(), threading.Event()

    class Slow(MemoryStore):
        def append(self, events: Sequence[e.Event]) -> None:
            self.at_disk()
            if any(isinstance(event, e.TaskStarted) for event in events):
                assert may_write.wait(60.0), 'the disk is only done when the goal is prepared'
            super().append(events)

    class Prepared(Gateway):
        def prepare(self, request: GoalRequest) -> None:
            super().prepare(request)
            may_write.set()

    writer, gateway = WriterThread(lambda: None), Prepared(line, clock)
    orchestrator = Orchestrator(line.cell, gateway, clock, Slow(), writer=writer)
    orchestrator.settle()
    orchestrator.ask(AddJobs((Job('J', line.script(WORK % ''), 1),)))
    for _ in range(2):
        orchestrator.settle()
    assert gateway.goals
    assert [goal.request for goal in gateway.goals] == gateway.prepared
    assert writer.close(60.0)
    orchestrator.close()


def test_a_write_says_when_it_waits() -> None:
    may_reach, may_end = threading.Event(), threading.Event()
    writer = WriterThread(lambda: None)

    def write() -> None:
        assert may_reach.wait(60.0)
        writer.reaches_disk()
        assert may_end.wait(60.0)

    writing = writer.begin(write)
    assert not writing.is_at_disk(0.0)
    may_reach.set()
    assert writing.is_at_disk(60.0)
    may_end.set()
    assert writing.has_ended(60.0)
    assert not writing.is_at_disk(60.0)
    silent = writer.begin(lambda: None)
    assert not silent.is_at_disk(60.0), 'its end is waited for no longer than it takes'
    assert silent.has_ended()
    assert writer.close(60.0)


def test_a_writer_that_hangs_is_left_behind() -> None:
    may_end = threading.Event()
    writer = WriterThread(lambda: None)
    writing = writer.begin(lambda: may_end.wait(60.0))
    assert not writer.close(0.0)
    may_end.set()
    assert writing.has_ended(60.0)
    assert writing.result()
    writer._thread.join(60.0)


def test_stopping_engine_waits_briefly_for_hung_reading(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr('bt_orchestrator.engine.runtime.orchestrator.READ_BACK_S', 0.1)
    line, clock, may_read = Line(), VirtualClock(), threading.Event()
    may_read.set()

    class Stuck(MemoryStore):
        def append(self, events: Sequence[e.Event]) -> None:
            if not may_read.is_set():
                raise JournalFailed('the disk is gone')
            super().append(events)

        def read(self, after: int = 0, most: int = -1) -> Sequence[e.Event]:
            assert may_read.wait(60.0)
            return super().read(after, most)

    readings = Readings(lambda call: call())
    orchestrator = Orchestrator(line.cell, Gateway(line, clock), clock, Stuck(), reader=readings)
    orchestrator.settle()
    may_read.clear()
    orchestrator.ask(AddJobs((Job('J', line.script(WORK % ''), 1),)))
    assert 'the disk is gone' in (orchestrator.broken or '')
    assert 'may be ahead of the journal: it does not answer' in caplog.text
    assert orchestrator.ask(Abort(ann())).accepted
    may_read.set()
    assert readings.close(60.0)
    orchestrator.close()


def test_readings_are_refused_when_too_many_wait() -> None:
    may_end, turns = threading.Event(), SimpleQueue[Callable[[], None]]()
    readings = Readings(turns.put)

    async def one() -> bool:
        return await readings.result_of(lambda: may_end.wait(60.0))

    waiting = [begin(one()) for _ in range(MOST_READINGS)]
    with pytest.raises(JournalUnusable, match='does not answer'):
        begin(one())
    may_end.set()
    while not waiting[-1].is_there:
        turns.get(timeout=60.0)()
    assert all(each.value for each in waiting)
    begin(one())
    assert readings.close(60.0)
