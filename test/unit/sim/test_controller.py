"""What one simulated controller does, on a virtual clock and without ROS."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import pytest

from bt_orchestrator.model.action_type import ActionType, FieldType, MessageType
from bt_orchestrator.model.cell import Component, StateTopic
from bt_orchestrator.model.fault import parse_fault
from bt_orchestrator.model.goal import GoalEnd, GoalRequest, GoalStatus
from bt_orchestrator.ports import Clock
from bt_orchestrator.sim.carrier import Answer, Verdict
from bt_orchestrator.sim.controller import Controller
from bt_orchestrator.sim.controllers.options import PacedClock
from bt_orchestrator.sim.gateway import VirtualClock

ACTION_TYPE = ActionType(
    'p/action/T',
    MessageType('Goal', {'task': FieldType('int', 'uint8')}),
    MessageType(
        'Result', {'task_result': FieldType('bool', 'boolean'), 'size': FieldType('int', 'int32')}
    ),
    {'A': 1, 'B': 2},
)


@dataclass
class FakeGoal:
    """A goal that remembers what it was told."""

    request: GoalRequest
    done: list[float] = field(default_factory=list)
    end: GoalEnd | None = None
    ended_at: float | None = None

    @property
    def status(self) -> GoalStatus | None:
        return self.end.status if self.end else None

    @property
    def result(self) -> Mapping[str, Any]:
        return self.end.result if self.end else {}


class FakeCarrier:
    """Remembers, with the time, how a controller showed itself."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self.seen: list[tuple[float, str]] = []
        self.at_ends: list[str] = []
        """What was seen last when a goal ended."""
        self.notes: list[tuple[str, str | None, Mapping[str, Any]]] = []
        """Event, goal, what else is told."""

    def appear(self) -> None:
        self._see('appears')

    def vanish(self) -> None:
        self._see('vanishes')

    def announce(self, ready: bool) -> None:
        self._see('ready' if ready else 'not ready')

    def show(self, setup: str, value: Any) -> None:
        self._see(f'{setup} {value}')

    def feedback(self, goal: FakeGoal, done: float) -> None:
        goal.done.append(done)

    def end(self, goal: FakeGoal, end: GoalEnd) -> None:
        assert goal.end is None, 'a goal ends once'
        goal.end, goal.ended_at = end, self._clock.steady()
        self.at_ends.append(self.seen[-1][1])

    def note(self, event: str, request: GoalRequest | None = None, **about: Any) -> None:
        self.notes.append((event, request.id if request else None, about))

    def _see(self, what: str) -> None:
        self.seen.append((self._clock.steady(), what))


class Bench:
    """One controller with everything around it; a task takes 4 s."""

    def __init__(self, *faults: str, feedback_s: float = 0.5, speed: float = 1.0) -> None:
        self.clock = VirtualClock()
        self.carrier = FakeCarrier(self.clock)
        component = Component(
            'arm',
            (1,),
            '/arm/task',
            'p/action/T',
            state=StateTopic('/arm/state', 'std_msgs/msg/String', 'data', ('READY',)),
            durations_s={'A': 4.0},
            results={'B': {'size': 3}},
            faults=tuple(parse_fault(spec) for spec in faults),
        )
        self.controller = Controller(
            component,
            ACTION_TYPE,
            self.carrier,
            PacedClock(self.clock, speed),
            lambda request: component.duration_s(request.task),
            feedback_s,
        )
        self.goals = 0
        self.is_there = self.controller.switch_on()

    def request(self, task: str = 'A') -> tuple[Answer, FakeGoal]:
        """Ask for a task, and start it if it was accepted."""
        self.goals += 1
        goal = FakeGoal(GoalRequest(f'g{self.goals}', 'arm', task))
        answer = self.controller.answer(goal.request)
        if answer.verdict is Verdict.ACCEPT:
            self.controller.start(goal)
        return answer, goal

    def accepted(self, task: str = 'A') -> FakeGoal:
        answer, goal = self.request(task)
        assert answer == Answer(Verdict.ACCEPT)
        return goal

    def finish(self) -> None:
        """Let time run until nothing is armed."""
        while self.clock.advance():
            pass


def test_task_takes_nominal_duration_and_succeeds() -> None:
    bench = Bench()
    goal = bench.accepted()
    bench.finish()

    assert (goal.ended_at, goal.status) == (4.0, GoalStatus.SUCCEEDED)
    assert goal.result == {'task_result': True, 'size': 0}


def test_results_come_from_cell_file_after_default_duration() -> None:
    bench = Bench()
    goal = bench.accepted(task='B')
    bench.finish()

    assert goal.ended_at == 1.0
    assert goal.result == {'task_result': True, 'size': 3}


def test_feedback_comes_at_the_start_and_at_intervals() -> None:
    bench = Bench(feedback_s=1.0)
    goal = bench.accepted()
    bench.finish()

    assert goal.done == [0.0, 0.25, 0.5, 0.75]


def test_zero_feedback_interval_gives_only_first_feedback() -> None:
    bench = Bench(feedback_s=0.0)
    goal = bench.accepted()
    bench.finish()

    assert goal.done == [0.0]


def test_speed_divides_the_seconds_of_tasks_and_faults() -> None:
    bench = Bench('#1=late:6', '#1=not_ready:20', speed=10.0)
    goal = bench.accepted()
    bench.finish()

    assert goal.ended_at == 1.0
    assert bench.carrier.seen[-2:] == [(1.0, 'not ready'), (3.0, 'ready')]


def test_second_concurrent_goal_is_rejected_and_not_counted() -> None:
    bench = Bench('#2=abort')
    first = bench.accepted()

    assert bench.request()[0].verdict is Verdict.REJECT

    bench.finish()
    second = bench.accepted()
    bench.finish()
    assert first.status is GoalStatus.SUCCEEDED
    assert second.status is GoalStatus.ABORTED


def test_a_cancel_request_is_obeyed_at_once() -> None:
    bench = Bench()
    goal = bench.accepted()

    assert bench.controller.cancel(goal.request.id)
    assert goal.status is GoalStatus.CANCELED

    bench.accepted()  # it is free again


def test_a_cancel_request_for_another_goal_is_refused() -> None:
    bench = Bench()
    goal = bench.accepted()

    assert not bench.controller.cancel('of yesterday')
    assert goal.status is None


@pytest.mark.parametrize(
    ('fault', 'status', 'time'),
    [
        ('=false', GoalStatus.SUCCEEDED, 4.0),
        ('=abort', GoalStatus.ABORTED, 4.0),
        ('=cancel', GoalStatus.CANCELED, 4.0),
        ('=late:2.5', GoalStatus.SUCCEEDED, 6.5),
        ('=hang', None, None),
        ('=ignore_cancel', None, None),
        ('=die', None, None),
    ],
)
def test_how_and_when_a_fault_ends_a_goal(
    fault: str, status: GoalStatus | None, time: float | None
) -> None:
    bench = Bench(fault)
    goal = bench.accepted()
    bench.finish()

    assert (goal.status, goal.ended_at) == (status, time)
    assert goal.result.get('task_result', False) is ('late' in fault)


def test_a_goal_that_hangs_obeys_a_cancel_request() -> None:
    bench = Bench('=hang')
    goal = bench.accepted()
    bench.finish()

    assert bench.controller.cancel(goal.request.id)
    assert goal.status is GoalStatus.CANCELED


def test_goal_that_ignores_cancel_keeps_running_forever() -> None:
    bench = Bench('=ignore_cancel')
    goal = bench.accepted()
    bench.finish()

    assert not bench.controller.cancel(goal.request.id)
    assert goal.status is None
    assert bench.request()[0].verdict is Verdict.REJECT


@pytest.mark.parametrize(
    ('fault', 'verdict'), [('=reject', Verdict.REJECT), ('=mute', Verdict.MUTE)]
)
def test_a_request_that_is_not_accepted_executes_nothing(fault: str, verdict: Verdict) -> None:
    bench = Bench(fault)

    assert bench.request()[0].verdict is verdict
    bench.accepted()  # the next goal finds it idle


def test_dead_controller_returns_later_without_its_goals() -> None:
    bench = Bench('#1=die:5')
    goal = bench.accepted()
    bench.finish()

    assert bench.carrier.seen == [
        (0.0, 'appears'),
        (0.0, 'ready'),
        (2.0, 'vanishes'),
        (7.0, 'appears'),
        (7.0, 'ready'),
    ]
    assert not bench.controller.cancel(goal.request.id)
    second = bench.accepted()
    bench.finish()
    assert second.status is GoalStatus.SUCCEEDED


def test_absent_controller_appears_late_or_never() -> None:
    late, never = Bench('=absent:3'), Bench('=absent')
    late.finish()
    never.finish()

    assert not late.is_there
    assert late.carrier.seen == [(3.0, 'appears'), (3.0, 'ready')]
    assert not never.carrier.seen


def test_initial_not_ready_is_the_first_state() -> None:
    bench = Bench('#0=not_ready:5')
    bench.finish()

    assert bench.carrier.seen == [(0.0, 'appears'), (0.0, 'not ready'), (5.0, 'ready')]


def test_an_absent_controller_may_come_unready() -> None:
    bench = Bench('=absent:3', '#0=not_ready')
    bench.finish()

    assert bench.carrier.seen == [(3.0, 'appears'), (3.0, 'not ready')]


def test_not_ready_after_a_goal_lasts_forever() -> None:
    bench = Bench('A#1=not_ready')
    bench.accepted()
    bench.finish()

    assert bench.carrier.seen[2:] == [(4.0, 'not ready')]


def test_not_ready_is_published_before_goal_end() -> None:
    bench = Bench('#1=not_ready')
    bench.accepted()
    bench.finish()

    assert bench.carrier.at_ends == ['not ready']


def test_earlier_not_ready_does_not_end_later_one() -> None:
    bench = Bench('#*=not_ready:5')
    bench.accepted()
    bench.clock.advance()  # feedback
    bench.controller.cancel('g1')
    bench.accepted()
    bench.finish()

    assert [time for time, what in bench.carrier.seen if what == 'ready'] == [0.0, 9.5]


def test_a_silent_state_topic_never_says_anything() -> None:
    bench = Bench('=silent', '#1=not_ready:1')
    bench.accepted()
    bench.finish()

    assert bench.carrier.seen == [(0.0, 'appears')]


def test_switched_off_controller_aborts_goal_and_rejects_others() -> None:
    bench = Bench()
    goal = bench.accepted()
    bench.controller.switch_off()

    assert goal.status is GoalStatus.ABORTED
    assert bench.request()[0].verdict is Verdict.REJECT


def test_first_listed_ending_counts_and_late_is_added() -> None:
    bench = Bench('=late:2.5', '=abort', '=hang')
    goal = bench.accepted()
    bench.finish()

    assert (goal.status, goal.ended_at) == (GoalStatus.ABORTED, 6.5)


def test_every_goal_is_noted_with_its_outcome() -> None:
    bench = Bench('#2=reject', '#3=mute', '#4=die')
    bench.accepted()
    bench.finish()
    bench.request()
    bench.request()
    bench.accepted()
    bench.finish()

    assert bench.carrier.notes == [
        ('appeared', None, {}),
        ('accepted', 'g1', {}),
        ('started', 'g1', {}),
        ('ended', 'g1', {'status': 'succeeded'}),
        ('rejected', 'g2', {'why': 'refused by the simulated controller'}),
        ('muted', 'g3', {}),
        ('accepted', 'g4', {}),
        ('started', 'g4', {}),
        ('died', 'g4', {}),
    ]
