"""What every ActionGateway does, whatever is at its other end (see ports/servers.py).

Subclass it and say how a bench is made.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from functools import partial

import pytest
from contract.fault_stories import STORIES, FaultyCell
from contract.gateway_bench import SERVER_TIMEOUT_S, TASK_S, Bench, Log, component, goal_request
from ros_domain import kept_domain

from bt_orchestrator.model.cell import Component
from bt_orchestrator.model.fault import FaultKind
from bt_orchestrator.model.goal import (
    RESULT_CHECK_S,
    SERVER_LEASE_S,
    GoalEnd,
    GoalStatus,
    SafetyReading,
    SeenContest,
    SetupReading,
    StateReading,
)
from bt_orchestrator.ports import Goal

SLACK_S = 15.0
"""How much later than due a busy machine may be."""

COMPONENTS = (
    component('good'),
    component('other'),
    component('hanging', '#*=hang'),
    component('late', '=late:0.6'),
    component('mute', '=mute'),
    component('mortal', '=die'),
    component('reborn', '=die:0.1'),
    component('renewed', '=die:0.1'),
    component('absent', '=absent'),
    component('tired', '=not_ready:0.5', state=True),
)


class GatewayContract(ABC):
    """The contract; one bench serves all tests, each with components of its own."""

    @staticmethod
    @abstractmethod
    def make_bench(components: Sequence[Component]) -> Bench:
        """Return a running bench."""

    @pytest.fixture(scope='class')
    @classmethod
    def bench(cls) -> Iterator[Bench]:
        with kept_domain():
            bench = cls.make_bench(COMPONENTS)
            yield bench
            bench.close()

    # --- ends -------------------------------------------------------------------------------

    def test_success_brings_all_result_fields(self, bench: Bench) -> None:
        end = _end_of(bench, _send(bench, 'good'))
        assert end.status is GoalStatus.SUCCEEDED
        assert end.result == {'task_result': True, 'item_present': True, 'measurement': 1.5}

    def test_prepared_goal_goes_out_once_on_send(self, bench: Bench) -> None:
        request = goal_request('other')
        bench.gateway.prepare(request)
        bench.run_for(2 * TASK_S)
        busy = bench.gateway.send(goal_request('other'))
        assert _end_of(bench, busy).status is GoalStatus.SUCCEEDED  # nothing else was there
        assert _end_of(bench, bench.gateway.send(request)).status is GoalStatus.SUCCEEDED

    def test_late_is_still_success(self, bench: Bench) -> None:
        goal = _send(bench, 'late')
        began = bench.now
        assert _end_of(bench, goal).status is GoalStatus.SUCCEEDED
        assert bench.now - began >= TASK_S + 0.6 - 0.05

    # --- faults (formats: faults of simulated controllers) ----------------------------------

    @pytest.fixture(scope='class')
    @classmethod
    def faulty(cls) -> Iterator[FaultyCell]:
        with kept_domain():
            bench = cls.make_bench(
                [component(kind.value, story.fault, state=True) for kind, story in STORIES.items()]
            )
            yield FaultyCell(bench, Log(bench.gateway))
            bench.close()

    @pytest.mark.parametrize('kind', FaultKind)
    def test_every_kind_of_fault(self, faulty: FaultyCell, kind: FaultKind) -> None:
        story, bench = STORIES[kind], faulty.bench
        # A topic keeps its last message alone: what it said first must have been heard.
        bench.run_until(lambda: faulty.said(kind)[:1] == list(story.said[:1]), 'its first word')
        first = _send(bench, kind.value)
        if story.hangs:
            bench.run_until(partial(_is_accepted, first), 'the acceptance')
            bench.run_for(3 * TASK_S)
            assert _is_open(first)
            first.cancel()
        if story.end is None:
            bench.run_for(1.0)
            assert _is_open(first)
        else:
            end = _end_of(bench, first)
            assert end.status is story.end
            assert end.result.get('task_result', False) is story.done
        assert first.accepted is story.accepted
        if story.then is not None:
            assert _end_of(bench, _send(bench, kind.value)).status is story.then
        wanted = list(story.said)
        bench.run_until(lambda: faulty.said(kind) == wanted, f'the topic to have said {wanted}')

    # --- states of a goal -------------------------------------------------------------------

    def test_is_requested_then_accepted_then_ended(self, bench: Bench) -> None:
        goal = _send(bench, 'good')
        assert not _is_accepted(goal)
        assert _is_open(goal)
        bench.run_until(partial(_is_accepted, goal), 'the acceptance')
        assert _is_open(goal)
        _run_to_end(bench, goal)
        assert goal.accepted

    def test_keeps_its_request(self, bench: Bench) -> None:
        goal = _send(bench, 'good')
        assert (goal.request.component, goal.request.task) == ('good', 'TASK_A')
        _run_to_end(bench, goal)

    def test_keeps_the_last_feedback(self, bench: Bench) -> None:
        goal = _send(bench, 'good')
        _run_to_end(bench, goal)
        assert goal.feedback is not None
        assert goal.feedback['current_sub_task'].startswith('TASK_A')
        later = _send(bench, 'good', 'TASK_B')
        # A quick server may have told something by now; it is about the later goal, or nothing.
        early_feedback = later.feedback
        _run_to_end(bench, later)
        assert early_feedback is None or early_feedback['current_sub_task'].startswith('TASK_B')

    def test_goals_of_two_components_do_not_mix(self, bench: Bench) -> None:
        long, short = _send(bench, 'good', 'TASK_B'), _send(bench, 'other', 'TASK_A')
        assert _end_of(bench, short).result['measurement'] == 1.5
        assert _is_open(long)
        assert _end_of(bench, long).result['measurement'] == 0.0

    # --- cancel -----------------------------------------------------------------------------

    def test_cancel_while_it_runs(self, bench: Bench) -> None:
        goal = _send(bench, 'hanging')
        bench.run_until(partial(_is_accepted, goal), 'the acceptance')
        goal.cancel()
        goal.cancel()
        assert _end_of(bench, goal).status is GoalStatus.CANCELED

    def test_cancel_before_acceptance_cancels_on_acceptance(self, bench: Bench) -> None:
        goal = _send(bench, 'hanging')
        goal.cancel()
        assert _is_open(goal)
        _run_to_end(bench, goal)
        assert goal.accepted
        assert goal.end is not None
        assert goal.end.status is GoalStatus.CANCELED

    def test_cancel_while_it_waits_withdraws_it(self, bench: Bench) -> None:
        goal = _send(bench, 'absent')
        goal.cancel()
        end = _end_of(bench, goal, within_s=SLACK_S)
        assert (end.status, end.never_begun) == (GoalStatus.CANCELED, True)
        assert not goal.accepted

    def test_engine_settles_when_a_goal_was_withdrawn(self, bench: Bench) -> None:
        woken: list[bool] = []
        bench.gateway.listen(lambda: woken.append(True))
        goal = _send(bench, 'absent')
        goal.cancel()
        bench.run_to_settle(woken, within_s=1.0)
        assert not _is_open(goal)
        assert goal in _goals(bench)

    def test_cancel_after_the_end_changes_nothing(self, bench: Bench) -> None:
        goal = _send(bench, 'good')
        _run_to_end(bench, goal)
        end = goal.end
        goal.cancel()
        bench.run_for(0.5)
        assert goal.end is end

    # --- servers that are not there ---------------------------------------------------------

    def test_no_server_for_good_is_unavailable(self, bench: Bench) -> None:
        began = bench.now
        end = _end_of(bench, _send(bench, 'absent'))
        assert end.status is GoalStatus.UNAVAILABLE
        assert '/absent/task' in end.message
        waited_s = bench.now - began
        assert SERVER_TIMEOUT_S - 0.1 <= waited_s <= SERVER_TIMEOUT_S + SLACK_S

    def test_waits_for_a_server_that_comes(self) -> None:
        bench = self.make_bench([component('late_riser', '=absent:1.5')])
        try:
            goal = _send(bench, 'late_riser')
            assert _end_of(bench, goal).status is GoalStatus.SUCCEEDED
        finally:
            bench.close()

    def test_available_says_whether_the_server_is_there(self, bench: Bench) -> None:
        bench.run_until(lambda: bench.gateway.available('good'), 'the server')
        assert not bench.gateway.available('absent')

    # --- servers that are lost (semantics 9.3) ----------------------------------------------

    def test_request_that_is_never_answered_is_lost(self, bench: Bench) -> None:
        goal = _send(bench, 'mute')
        began = bench.now
        assert _end_of(bench, goal).status is GoalStatus.LOST
        assert RESULT_CHECK_S <= bench.now - began <= 2 * RESULT_CHECK_S + SLACK_S
        assert not goal.accepted

    def test_server_that_dies_and_stays_away_is_lost(self, bench: Bench) -> None:
        goal = _send(bench, 'mortal')
        bench.run_until(partial(_is_accepted, goal), 'the acceptance')
        assert _end_of(bench, goal, within_s=2 * SERVER_LEASE_S).status is GoalStatus.LOST
        assert goal.accepted
        bench.run_until(lambda: not bench.gateway.available('mortal'), 'it to be gone', SLACK_S)

    def test_server_that_restarts_at_once_loses_goal(self, bench: Bench) -> None:
        goal = _send(bench, 'reborn')
        began = bench.now
        assert _end_of(bench, goal).status is GoalStatus.LOST
        assert bench.now - began <= RESULT_CHECK_S + SLACK_S
        again = _send(bench, 'reborn')
        assert _end_of(bench, again).status is GoalStatus.SUCCEEDED

    # --- taking over (semantics 9.2) --------------------------------------------------------

    def test_adopts_a_goal_that_runs(self, bench: Bench) -> None:
        goal = _send(bench, 'good', 'TASK_B')
        bench.run_until(partial(_is_accepted, goal), 'the acceptance')
        adopted = bench.gateway.adopt(goal.request)
        end = _end_of(bench, adopted)
        assert (end.status, end.result['measurement']) == (GoalStatus.SUCCEEDED, 0.0)
        assert adopted.accepted

    def test_adopts_a_goal_that_has_ended(self, bench: Bench) -> None:
        goal = _send(bench, 'good')
        end = _end_of(bench, goal)
        bench.run_for(1.0)
        assert _end_of(bench, bench.gateway.adopt(goal.request), SLACK_S) == end

    def test_cancels_an_adopted_goal(self, bench: Bench) -> None:
        goal = _send(bench, 'hanging')
        bench.run_until(partial(_is_accepted, goal), 'the acceptance')
        adopted = bench.gateway.adopt(goal.request)
        adopted.cancel()
        assert _end_of(bench, adopted).status is GoalStatus.CANCELED
        _run_to_end(bench, goal)

    def test_adopted_goal_unknown_to_server_is_lost(self, bench: Bench) -> None:
        adopted = bench.gateway.adopt(goal_request('good'))
        end = _end_of(bench, adopted, RESULT_CHECK_S + SLACK_S)
        assert end.status is GoalStatus.LOST
        assert not adopted.accepted
        assert end.denied_by is not None
        assert end.denied_by == bench.gateway.server('good')

    def test_a_server_has_another_id_after_a_restart(self, bench: Bench) -> None:
        before = bench.gateway.server('renewed')
        goal = _send(bench, 'renewed')
        bench.run_until(lambda: goal.end, 'the loss of the goal', SERVER_LEASE_S + SLACK_S)
        _run_to_end(bench, _send(bench, 'renewed'))
        assert None not in (before, bench.gateway.server('renewed'))
        assert bench.gateway.server('renewed') != before

    def test_two_servers_have_two_ids(self, bench: Bench) -> None:
        assert bench.gateway.server('good') == bench.gateway.server('good')
        assert bench.gateway.server('good') != bench.gateway.server('other')

    def test_a_server_that_never_came_has_no_id(self, bench: Bench) -> None:
        assert bench.gateway.server('absent') is None

    def test_adopted_goal_without_a_server_is_lost(self, bench: Bench) -> None:
        adopted = bench.gateway.adopt(goal_request('absent'))
        assert _end_of(bench, adopted).status is GoalStatus.LOST

    # --- what is told -----------------------------------------------------------------------

    def test_lists_goal_on_acceptance_and_on_end(self, bench: Bench) -> None:
        goal = _send(bench, 'good')
        bench.gateway.drain()
        bench.run_until(partial(_is_accepted, goal), 'the acceptance')
        assert _goals(bench) == (goal,)
        assert _goals(bench) == ()
        _run_to_end(bench, goal)
        assert _goals(bench) == (goal,)
        bench.run_for(0.5)
        assert _goals(bench) == ()

    def test_lists_each_goal_once_oldest_end_first(self, bench: Bench) -> None:
        bench.gateway.drain()
        slow, quick = _send(bench, 'good', 'TASK_B'), _send(bench, 'other', 'TASK_A')
        _run_to_end(bench, slow)
        assert _goals(bench) == (quick, slow)

    def test_end_wakes_listeners_but_acceptance_does_not(self) -> None:
        bench = self.make_bench([component('good')])  # a state topic would wake it, too
        try:
            log = Log(bench.gateway)
            woken: list[Sequence[object]] = []
            bench.gateway.listen(lambda: woken.append(log.update()))
            goal = _send(bench, 'good')
            bench.run_until(partial(_is_accepted, goal), 'the acceptance')
            assert woken == [], woken
            _run_to_end(bench, goal)
            assert woken == [[goal]], woken
        finally:
            bench.close()

    # --- state topics (semantics 2.5) -------------------------------------------------------

    def test_reports_initial_state_and_only_its_changes(self) -> None:
        bench = self.make_bench(
            [
                component('ready', state=True),
                component('not_ready', '#0=not_ready', state=True),
                component('silent', '=silent', state=True),
            ]
        )
        try:
            log = Log(bench.gateway)
            bench.run_until(lambda: log.readings('ready'), 'a reading')
            bench.run_until(lambda: log.readings('not_ready'), 'a reading')
            bench.run_for(2.5)
            assert log.readings('ready') == ['READY']
            assert log.readings('not_ready') == ['NOT_READY']
            assert log.readings('silent') == []
        finally:
            bench.close()

    def test_tells_a_change_of_state(self, bench: Bench) -> None:
        log = Log(bench.gateway)
        _run_to_end(bench, _send(bench, 'tired'))
        states = ['NOT_READY', 'READY']
        bench.run_until(lambda: log.readings('tired')[-2:] == states, 'not ready, and ready again')

    def test_tells_that_a_state_topic_lost_its_publisher(self) -> None:
        bench = self.make_bench([component('lost_state', '=die', state=True)])
        try:
            log = Log(bench.gateway)
            bench.run_until(lambda: log.readings('lost_state'), 'a reading')
            _run_to_end(bench, _send(bench, 'lost_state'), within_s=2 * SERVER_LEASE_S)
            bench.run_until(lambda: log.readings('lost_state')[-1:] == [None], 'the loss')
        finally:
            bench.close()

    def test_reports_setup_before_state_and_before_goal_end(self) -> None:
        bench = self.make_bench([component('told', tells=True), component('mute', tells=True)])
        try:
            log = Log(bench.gateway)
            bench.run_until(lambda: log.readings('told') and log.readings('mute'), 'the states')
            assert log.setups('told') == ['']
            mine = [entry for entry in log.entries if vars(entry).get('component') == 'told']
            assert [type(entry) for entry in mine] == [SetupReading, StateReading]
            goal = bench.gateway.send(goal_request('told', 'TASK_A', special_argument_1='large'))
            bench.run_until(lambda: log.setups('told')[-1:] == ['large'], 'the new setup')
            _run_to_end(bench, goal)
            assert log.setups('told') == ['', 'large']
            assert log.setups('mute') == [''], 'each has its own'
        finally:
            bench.close()

    def test_tells_that_nothing_tells_a_setup_any_more(self) -> None:
        bench = self.make_bench([component('lost_setup', '=die', tells=True)])
        try:
            log = Log(bench.gateway)
            bench.run_until(lambda: log.readings('lost_setup'), 'a reading')
            _run_to_end(bench, _send(bench, 'lost_setup'), within_s=2 * SERVER_LEASE_S)
            bench.run_until(lambda: log.setups('lost_setup') == ['', None], 'the loss')
        finally:
            bench.close()


def _goals(bench: Bench) -> tuple[Goal, ...]:
    """Return what is new of goals; components of other tests tell of their states as well."""
    others = (StateReading, SetupReading, SafetyReading, SeenContest)
    return tuple(new for new in bench.gateway.drain() if not isinstance(new, others))


def _send(bench: Bench, name: str, task: str = 'TASK_A') -> Goal:
    return bench.gateway.send(goal_request(name, task))


def _run_to_end(bench: Bench, goal: Goal, within_s: float = 60.0) -> None:
    bench.run_until(lambda: goal.end is not None, f'the end of {goal.request}', within_s)


def _is_accepted(goal: Goal) -> bool:
    return goal.accepted


def _is_open(goal: Goal) -> bool:
    return goal.end is None


def _end_of(bench: Bench, goal: Goal, within_s: float = 60.0) -> GoalEnd:
    _run_to_end(bench, goal, within_s)
    assert goal.end is not None
    return goal.end
