"""An action server made of its parts: three services that wait for no client, and two topics.

rclpy's own server answers goal, cancel and result requests itself, and each answer to a client
that has left would keep the thread for 0.1 s (`patient_service.py`).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

from action_msgs.msg import GoalInfo, GoalStatus, GoalStatusArray
from action_msgs.srv import CancelGoal
from rclpy.node import Node

from bt_orchestrator.base.replies import Reply, Steps, begin
from bt_orchestrator.ros.qos import LATCHED, SERVICES, publisher
from bt_orchestrator.ros.services.patient_service import create_patient_service

RESULT_KEPT_S = 900.0
"""How long a result is kept for a client that comes back for it."""

_EXECUTING: int = GoalStatus.STATUS_EXECUTING
_CANCELING: int = GoalStatus.STATUS_CANCELING


@dataclass(eq=False)
class ServedGoal:
    """A goal that was accepted. States: as in `action_msgs/msg/GoalStatus`."""

    info: GoalInfo
    """Its UUID, and when it was accepted."""
    request: Any
    """The goal message."""
    status: int = _EXECUTING
    result: Reply[Any] = field(default_factory=Reply)
    """The answer to those who ask for the result."""
    ended_s: float = 0.0
    """When it ended, on the steady clock."""

    @property
    def is_cancel_requested(self) -> bool:
        """Tell whether a cancel request was accepted and it has not ended."""
        return self.status == _CANCELING

    @property
    def is_running(self) -> bool:
        """Tell whether it has not ended."""
        return self.status in (_EXECUTING, _CANCELING)


class GoalServer:
    """Serves an action. To be used in the executor's thread."""

    def __init__(
        self,
        node: Node,
        kind: Any,
        name: str,
        *,
        admits: Callable[[], bool],
        start: Callable[[ServedGoal], None],
        cancel: Callable[[ServedGoal], Steps[bool]],
        steady: Callable[[], float] = time.monotonic,
    ) -> None:
        """Offer the action.

        :param kind: the class of the action
        :param admits: tells whether another goal is accepted
        :param start: begins a goal that was accepted; raises nothing
        :param cancel: decides on a cancel request; raises nothing
        """
        self._node = node
        self._impl = kind.Impl
        self._result = kind.Result
        self._admits = admits
        self._start = start
        self._cancel = cancel
        self._steady = steady
        self._goals: dict[bytes, ServedGoal] = {}
        within = f'{name}/_action'
        for service, its_kind, answer in (
            ('send_goal', self._impl.SendGoalService, self._take_goal),
            ('cancel_goal', self._impl.CancelGoalService, self._take_cancel),
            ('get_result', self._impl.GetResultService, self._take_result_request),
        ):
            create_patient_service(node, its_kind, f'{within}/{service}', answer)
        self._feedback = publisher(
            node, self._impl.FeedbackMessage, f'{within}/feedback', SERVICES
        )
        self._status = publisher(node, self._impl.GoalStatusMessage, f'{within}/status', LATCHED)

    def feed_back(self, goal: ServedGoal, feedback: Any) -> None:
        """Publish feedback on a goal."""
        message = self._impl.FeedbackMessage(goal_id=goal.info.goal_id, feedback=feedback)
        self._feedback.publish(message)

    def end(self, goal: ServedGoal, status: int, result: Any) -> None:
        """End a goal, and answer all who ask for its result.

        :param status: of `action_msgs/msg/GoalStatus`
        """
        goal.status, goal.ended_s = status, self._steady()
        goal.result.give(self._impl.GetResultService.Response(status=status, result=result))
        self._publish_status()

    # --- requests ---------------------------------------------------------------------------

    def _take_goal(self, request: Any, response: Any) -> Any:
        self._forget_old()
        name = bytes(request.goal_id.uuid)
        response.accepted = name not in self._goals and self._admits()
        response.stamp = self._node.get_clock().now().to_msg()
        if response.accepted:
            info = GoalInfo(goal_id=request.goal_id, stamp=response.stamp)
            goal = self._goals[name] = ServedGoal(info, request.goal)
            self._publish_status()
            self._start(goal)
        return response

    def _take_result_request(self, request: Any, response: Any) -> Any:
        self._forget_old()
        goal = self._goals.get(bytes(request.goal_id.uuid))
        if goal is not None:
            return goal.result
        response.status, response.result = GoalStatus.STATUS_UNKNOWN, self._result()
        return response

    def _take_cancel(self, request: Any, response: Any) -> Reply[Any]:
        return begin(self._cancel_all(request.goal_info, response))

    async def _cancel_all(self, asked: GoalInfo, response: Any) -> Any:
        goals = list(_meant(asked, self._goals.values()))
        wanted = [goal for goal in goals if goal.status == _EXECUTING]
        for goal in wanted:
            goal.status = _CANCELING  # it may end before the decision is told
            if await self._cancel(goal):
                response.goals_canceling.append(goal.info)
            elif goal.is_running:
                goal.status = _EXECUTING
        if response.goals_canceling:
            self._publish_status()
        response.return_code = _return_code(asked, goals, wanted, response.goals_canceling)
        return response

    def _publish_status(self) -> None:
        each = [
            GoalStatus(goal_info=goal.info, status=goal.status) for goal in self._goals.values()
        ]
        self._status.publish(GoalStatusArray(status_list=each))

    def _forget_old(self) -> None:
        """Forget the goals whose results were kept long enough."""
        until_s = self._steady() - RESULT_KEPT_S
        self._goals = {
            name: goal
            for name, goal in self._goals.items()
            if goal.is_running or goal.ended_s > until_s
        }


def _meant(asked: GoalInfo, goals: Iterable[ServedGoal]) -> Iterator[ServedGoal]:
    """Yield the goals that a cancel request means (`action_msgs/srv/CancelGoal`).

    One by its UUID, those accepted up to a time, or both; with neither, all.
    """
    until = _instant(asked)
    is_all = not _is_one(asked) and not any(until)
    for goal in goals:
        is_named = _is_one(asked) and bytes(goal.info.goal_id.uuid) == bytes(asked.goal_id.uuid)
        if is_all or is_named or _instant(goal.info) <= until:
            yield goal


def _is_one(asked: GoalInfo) -> bool:
    return any(asked.goal_id.uuid)


def _instant(info: GoalInfo) -> tuple[int, int]:
    return info.stamp.sec, info.stamp.nanosec


def _return_code(
    asked: GoalInfo, goals: list[ServedGoal], wanted: list[ServedGoal], canceling: list[GoalInfo]
) -> int:
    if canceling:
        return int(CancelGoal.Response.ERROR_NONE)
    if wanted:
        return int(CancelGoal.Response.ERROR_REJECTED)
    if not _is_one(asked):
        return int(CancelGoal.Response.ERROR_NONE)
    if goals:
        return int(CancelGoal.Response.ERROR_GOAL_TERMINATED)
    return int(CancelGoal.Response.ERROR_UNKNOWN_GOAL_ID)
