"""An action server made of its parts, as clients of rclpy see it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from action_caller import ActionCaller
from action_msgs.msg import GoalInfo, GoalStatus, GoalStatusArray
from action_msgs.srv import CancelGoal
from bt_orchestrator_interfaces.action import RunJob
from bt_orchestrator_interfaces.msg import JobStatus
from builtin_interfaces.msg import Time
from rclpy.action import get_action_names_and_types  # type: ignore[attr-defined] # not in its __all__
from unique_identifier_msgs.msg import UUID

from bt_orchestrator.ros.qos import LATCHED
from bt_orchestrator.ros.services.goal_server import RESULT_KEPT_S, GoalServer, ServedGoal

pytestmark = pytest.mark.every_distro

NAME = '/serve'
ANSWER = CancelGoal.Response
EXECUTING, CANCELING = GoalStatus.STATUS_EXECUTING, GoalStatus.STATUS_CANCELING
SUCCEEDED, CANCELED = GoalStatus.STATUS_SUCCEEDED, GoalStatus.STATUS_CANCELED


class Served:
    """A server whose goals end when the test says so, and a client of it."""

    def __init__(self) -> None:
        self.ros = ActionCaller()
        self.goals: list[ServedGoal] = []
        self.is_open = self.obeys = True
        self.now_s = 0.0
        self.server = GoalServer(
            self.ros.node,
            RunJob,
            NAME,
            admits=lambda: self.is_open,
            start=self.goals.append,
            cancel=self._cancel,
            steady=lambda: self.now_s,
        )
        self._told: list[GoalStatusArray] = []
        self.ros.node.create_subscription(
            GoalStatusArray, f'{NAME}/_action/status', self._told.append, LATCHED
        )
        self._cancels: Any = self.ros.node.create_client(CancelGoal, f'{NAME}/_action/cancel_goal')

    async def _cancel(self, _: ServedGoal) -> bool:
        return self.obeys

    def start(self, **options: Any) -> Any:
        """Send a goal; return what its client holds."""
        return self.ros.start(NAME, RunJob, RunJob.Goal(), **options)

    def cancel(self, goal: Any = None, until: Time | None = None) -> Any:
        """Return the answer to a cancel request: for one goal, those up to a time, or all."""
        info = GoalInfo(goal_id=goal or UUID(), stamp=until or Time())
        self.ros.spin_until(self._cancels.service_is_ready, 'the cancel service')
        asked = self._cancels.call_async(CancelGoal.Request(goal_info=info))
        return self.ros.wait(asked, 'the answer to a cancel request')

    def end(self, number: int, status: int, job: str = '') -> None:
        """End a goal."""
        self.server.end(self.goals[number], status, RunJob.Result(job=job))

    def await_status(self, *statuses: int) -> None:
        """See that the status topic says so of all goals, in their order."""

        def is_said() -> bool:
            last = self._told[-1].status_list if self._told else []
            return tuple(goal.status for goal in last) == statuses

        self.ros.spin_until(is_said, f'the status {statuses}')


@pytest.fixture
def served() -> Iterator[Served]:
    served = Served()
    yield served
    served.ros.close()


def test_a_goal_is_followed_to_its_result(served: Served) -> None:
    heard: list[Any] = []
    handle = served.start(on_feedback=heard.append)
    assert handle.accepted
    served.await_status(EXECUTING)
    first = handle.get_result_async()
    served.server.feed_back(served.goals[0], RunJob.Feedback(status=JobStatus(id='A')))
    served.ros.spin_until(lambda: heard, 'feedback')
    assert heard[0].feedback.status.id == 'A'
    assert not first.done()

    served.end(0, SUCCEEDED, job='A')
    end = served.ros.wait(first, 'the result')
    assert (end.status, end.result.job) == (SUCCEEDED, 'A')
    served.await_status(SUCCEEDED)
    assert served.ros.result(handle).result.job == 'A', 'also who asks later gets it'


def test_the_graph_shows_an_action(served: Served) -> None:
    served.start()
    names = dict(get_action_names_and_types(served.ros.node))
    assert names[NAME] == ['bt_orchestrator_interfaces/action/RunJob']


def test_a_goal_that_is_not_admitted_leaves_nothing(served: Served) -> None:
    served.is_open = False
    assert not served.start().accepted
    assert served.goals == []


def test_goal_with_duplicate_uuid_is_rejected(served: Served) -> None:
    name = UUID(uuid=list(range(16)))
    client = served.ros.client(NAME, RunJob)
    served.start()
    accepted = [
        served.ros.wait(
            client.send_goal_async(RunJob.Goal(), goal_uuid=name), 'an answer'
        ).accepted
        for _ in range(2)
    ]
    assert accepted == [True, False]
    assert len(served.goals) == 2


def test_result_expires_but_running_goal_stays(served: Served) -> None:
    ended, running = served.start(), served.start()
    served.end(0, SUCCEEDED, job='A')
    served.now_s = RESULT_KEPT_S - 1
    assert served.ros.result(ended).status == SUCCEEDED
    served.now_s = RESULT_KEPT_S
    assert served.ros.result(ended).status == GoalStatus.STATUS_UNKNOWN
    served.now_s = 10 * RESULT_KEPT_S
    last = running.get_result_async()
    served.end(1, SUCCEEDED, job='B')
    assert served.ros.wait(last, 'the result').result.job == 'B'


def test_one_goal_is_cancelled(served: Served) -> None:
    served.start()
    handle = served.start()
    answer = served.cancel(handle.goal_id)
    assert answer.return_code == ANSWER.ERROR_NONE
    assert [info.goal_id for info in answer.goals_canceling] == [handle.goal_id]
    assert [goal.is_cancel_requested for goal in served.goals] == [False, True]
    served.await_status(EXECUTING, CANCELING)
    assert served.cancel(handle.goal_id).return_code == ANSWER.ERROR_GOAL_TERMINATED, 'once'
    served.end(1, CANCELED)
    assert served.ros.result(handle).status == CANCELED


def test_cancel_stops_all_goals_or_those_until_stamp(served: Served) -> None:
    for _ in range(3):
        served.start()
    answer = served.cancel(until=served.goals[1].info.stamp)
    assert len(answer.goals_canceling) == 2
    served.await_status(CANCELING, CANCELING, EXECUTING)
    assert len(served.cancel().goals_canceling) == 1
    assert served.cancel().return_code == ANSWER.ERROR_NONE, 'there is none left'


def test_who_cannot_be_cancelled_goes_on(served: Served) -> None:
    handle = served.start()
    served.obeys = False
    assert served.cancel(handle.goal_id).return_code == ANSWER.ERROR_REJECTED
    assert served.goals[0].status == EXECUTING
    unknown = UUID(uuid=[1] * 16)
    assert served.cancel(unknown).return_code == ANSWER.ERROR_UNKNOWN_GOAL_ID
    served.end(0, SUCCEEDED)
    assert served.cancel(handle.goal_id).return_code == ANSWER.ERROR_GOAL_TERMINATED


def test_goal_ending_during_cancel_decision_sees_the_request(served: Served) -> None:
    async def ends(goal: ServedGoal) -> bool:
        assert goal.is_cancel_requested
        served.server.end(goal, CANCELED, RunJob.Result())
        return True

    handle = served.start()
    served.server._cancel = ends
    assert len(served.cancel(handle.goal_id).goals_canceling) == 1
    assert served.goals[0].status == CANCELED
