"""rclpy's action client, for one who asks again by UUID. The only place that knows its inside."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.action.client import ActionClient, ClientGoalHandle
from rclpy.node import Node
from unique_identifier_msgs.msg import UUID

from bt_orchestrator.ros.callbacks import report

_ACTIVE = (GoalStatus.STATUS_ACCEPTED, GoalStatus.STATUS_EXECUTING, GoalStatus.STATUS_CANCELING)

_ENDED = {
    GoalStatus.STATUS_SUCCEEDED: 'succeeded',
    GoalStatus.STATUS_CANCELED: 'was canceled',
    GoalStatus.STATUS_ABORTED: 'was aborted',
}


class GoalClient(ActionClient):  # type: ignore[type-arg] # no Generic in Jazzy's rclpy
    """An action client without the habits of rclpy's that hurt here.

    - Its futures are kept from the executor, which would make a task, and so another turn, of
      each of their callbacks. They are called at once, in the executor's thread. That also ends
      the leak of rclpy 7.1.6 and 9.1.2, where one future a goal stayed in the list for ever.
    - A result may be asked for any number of times; for each question a small entry is kept,
      no future, until the goal is forgotten.
    - An exception while handling what was taken is reported, and does not end the spinning.
    """

    def __init__(self, node: Node, action_class: Any, name: str) -> None:
        self._asked: dict[bytes, list[int]] = {}
        self._unconfirmed: dict[bytes, Callable[[bool], None]] = {}
        self._listed: Any = ()
        super().__init__(node, action_class, name)
        self._entities: Any = super().get_num_entities()

    @property
    def node(self) -> Node:
        """The node that it belongs to."""
        return self._node

    def get_num_entities(self) -> Any:
        """Return what does not change, and what the executor asks for in every turn."""
        return self._entities

    def add_future(self, future: Any) -> None:
        """Do not tell the executor of a future (rclpy's Waitable interface)."""

    def remove_future(self, future: Any) -> None:
        """Do nothing: it was not told (rclpy's Waitable interface)."""

    async def execute(self, taken_data: Any) -> None:
        """Handle what was taken from the middleware (rclpy's Waitable interface)."""
        for kind, data in taken_data.items():
            try:
                if kind == 'status':
                    self._listed = data.status_list
                    self._confirm()
                elif kind == 'result':
                    self._answer(*data)
                else:
                    one: Any = {kind: data}
                    await super().execute(one)
            except Exception:  # noqa: BLE001 - whatever it is, the other goals go on
                report(self._logger)

    def server_id(self) -> str | None:
        """Return an id of the server's status publisher, which no other instance of it has.

        None: there is no server, or more than one. Takes a tenth of a millisecond.
        """
        topic = f'{self._action_name}/_action/status'
        publishers = self._node.get_publishers_info_by_topic(topic)
        return bytes(publishers[0].endpoint_gid).hex() if len(publishers) == 1 else None

    def expect(self, goal_id: UUID, listed: Callable[[bool], None]) -> None:
        """Call back, once, when the server's status topic lists a goal: it was accepted.

        The answer to a request can be lost, when the server had not discovered this client yet.
        For a goal that is listed already it calls back at once.

        :param listed: gets whether the goal runs; of one that ended the server may know no more
            than its latched status still says
        """
        self._unconfirmed[bytes(goal_id.uuid)] = listed
        self._confirm()

    @property
    def is_busy(self) -> bool:
        """Tell whether the server's last status lists a goal that runs, anybody's.

        Such a server may be silent for long: it answers for a goal at its end, and one that works
        in the thread of its callbacks answers nothing meanwhile.
        """
        return any(status.status in _ACTIVE for status in self._listed)

    def listed_end(self, goal_id: UUID) -> str | None:
        """Return, in words, how a goal ended by the last status; None: that is not said."""
        key = bytes(goal_id.uuid)
        found = (s.status for s in self._listed if bytes(s.goal_info.goal_id.uuid) == key)
        return _ENDED.get(next(found, GoalStatus.STATUS_UNKNOWN))

    def follow(self, goal_id: UUID, on_feedback: Callable[[Any], None]) -> None:
        """Hear the feedback of a goal that another client sent."""
        self._feedback_callbacks[bytes(goal_id.uuid)] = on_feedback

    def ask_result(self, goal_id: UUID, answered: Callable[[Any], None]) -> None:
        """Ask for the result of a goal of any client; an unknown goal is answered at once.

        :param answered: called with each answer, which has `status` and `result`
        """
        self._get_result_async(self._handle(goal_id))
        sequence = next(reversed(self._pending_result_requests))
        del self._result_sequence_number_to_goal_id[sequence]
        pending: dict[int, Any] = self._pending_result_requests
        pending[sequence] = answered  # where rclpy has a future
        self._asked.setdefault(bytes(goal_id.uuid), []).append(sequence)

    def request_cancel(self, goal_id: UUID) -> None:
        """Ask to cancel a goal of any client; the answer does not matter, its end will tell."""
        self._cancel_goal_async(self._handle(goal_id))

    def forget(self, goal_id: UUID) -> None:
        """Free what was kept for a goal, open questions too: a busy server may drop some."""
        key = bytes(goal_id.uuid)
        self._feedback_callbacks.pop(key, None)
        self._goal_handles.pop(key, None)
        self._unconfirmed.pop(key, None)
        for sequence in self._asked.pop(key, ()):
            self._pending_result_requests.pop(sequence, None)

    def forget_request(self, response: Any) -> None:
        """Stop waiting for the answer to a goal request.

        :param response: the future of `send_goal_async`
        """
        self._remove_pending_goal_request(response)

    def forget_cancels(self) -> None:
        """Stop waiting for answers to cancel requests."""
        self._pending_cancel_requests.clear()

    def _confirm(self) -> None:
        if not self._unconfirmed:
            return
        for status in self._listed:
            key = bytes(status.goal_info.goal_id.uuid)
            listed = self._unconfirmed.pop(key, None)
            if listed is not None:
                listed(status.status in _ACTIVE)

    def _answer(self, sequence: int, response: Any) -> None:
        """Pass a result on; one more answer about a goal that has ended is no news."""
        answered: Any = self._pending_result_requests.get(sequence)
        if answered is not None:
            answered(response)

    def _handle(self, goal_id: UUID) -> Any:
        """Make a goal handle by hand, the only way to speak of a goal that nobody answered for."""
        response = self._action_type.Impl.SendGoalService.Response(accepted=True)
        return ClientGoalHandle(self, goal_id, response)
