"""The connection to one action server: sending goals, hearing of them, and losing the server."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from action_msgs.msg import GoalStatus as WireStatus
from rclpy.node import Node

from bt_orchestrator.model.action_type import TASK, ActionType
from bt_orchestrator.model.cell import Component
from bt_orchestrator.model.goal import (
    REQUEST_CHECKS,
    RESULT_CHECK_S,
    SILENCE_S,
    GoalEnd,
    GoalRequest,
    GoalStatus,
)
from bt_orchestrator.news import News
from bt_orchestrator.ros.callbacks import report
from bt_orchestrator.ros.goal import RosGoal
from bt_orchestrator.ros.goal_client import GoalClient
from bt_orchestrator.ros.messages import fill, to_plain
from bt_orchestrator.ros.renewable_client import RenewableClient

_ENDS = {
    WireStatus.STATUS_SUCCEEDED: GoalStatus.SUCCEEDED,
    WireStatus.STATUS_ABORTED: GoalStatus.ABORTED,
    WireStatus.STATUS_CANCELED: GoalStatus.CANCELED,
}

_GIVEN_UP = (GoalStatus.LOST, GoalStatus.SILENT)

SERVER_LOOK_S = 1.0
"""Shortest time between two looks at which instance of the server it is; each takes a while."""

_MOST_UNANSWERED = 16
"""Requests given up whose late answer is still listened to."""

_SEEK_S = 3.0
"""Seconds without a server after which it is looked for in a fresh way."""


class ActionLink:
    """One component's action client and the goals it has open.

    A goal is waiting (for the server), then in flight, then ended and not known here any more.
    Whatever comes for a goal that has ended is dropped; a late yes to a request is cancelled, so
    that no goal is orphaned (semantics 2.4).
    """

    def __init__(
        self,
        node: Node,
        component: Component,
        action_class: Any,
        action_type: ActionType,
        news: News,
        server_timeout_s: float,
        now: Callable[[], float],
        fresh_node: Callable[[], Node],
    ) -> None:
        """Make the client.

        :param now: seconds of the node's clock, for feedback
        :param fresh_node: returns a node with a fresh participant
        """
        self._component = component
        self._class = action_class
        self._type = action_type
        self._news = news
        self._server_timeout_s = server_timeout_s
        self._now = now
        self._logger = node.get_logger().get_child(component.name)
        self._clients = RenewableClient(node, action_class, component.action, fresh_node)
        self._waiting: dict[RosGoal, float] = {}
        self._in_flight: dict[RosGoal, None] = {}
        self._unanswered: list[Any] = []
        self._seen_missing = False
        self._server: str | None = None
        self._server_seen_s = 0.0

    @property
    def _client(self) -> GoalClient:
        return self._clients.current

    @property
    def nodes(self) -> Iterator[Node]:
        """Nodes that its clients use."""
        return self._clients.nodes

    @property
    def available(self) -> bool:
        """Tell whether the server is in the ROS graph."""
        return self._client.server_is_ready()

    @property
    def server(self) -> str | None:
        """Id of the server's status publisher, as it was seen last."""
        if self._server is None:
            self._server = self._client.server_id()
        return self._server

    @property
    def is_waiting(self) -> bool:
        """Tell whether goals wait for the server."""
        return bool(self._waiting)

    @property
    def is_open(self) -> bool:
        """Tell whether there is anything that `poll` or `watch` has to look after."""
        return bool(self._waiting or self._in_flight or self._unanswered)

    def send(self, request: GoalRequest) -> RosGoal:
        """Send a goal, or let it wait for the server."""
        return self._open(RosGoal(request, self.cancel))

    def adopt(self, request: GoalRequest) -> RosGoal:
        """Take over a goal that an earlier process sent (semantics 9.2)."""
        goal = RosGoal(request, self.cancel)
        goal.adopted = True
        return self._open(goal)

    def cancel(self, goal: RosGoal) -> None:
        """Pass a cancel request on, or withdraw a goal that was not sent."""
        if goal.end is not None:
            return
        goal.cancel_requested = True
        if goal in self._waiting and not goal.adopted:
            self._end(goal, GoalStatus.CANCELED, message='withdrawn before it was sent')
        elif goal.accepted or (goal.adopted and goal in self._in_flight):
            self._client.request_cancel(goal.id)

    def poll(self) -> None:
        """Send what waits, if the server has come; give up what waited too long."""
        self._send_waiting()
        now = time.monotonic()
        if self._clients.may_be_renewed and self._has_waited(_SEEK_S, now):
            self._clients.renew()
        for goal in [goal for goal, until in self._waiting.items() if until <= now]:
            status = GoalStatus.LOST if goal.adopted else GoalStatus.UNAVAILABLE
            message = f'no server of {self._component.action} within {self._server_timeout_s:g} s'
            self._end(goal, status, message=message)

    def watch(self) -> None:
        """Look after the goals in flight (semantics 9.3)."""
        if not (self._in_flight or self._unanswered):
            self._seen_missing = False
        elif self.available:
            self._seen_missing = False
            self._check()
        elif self._clients.is_looking:
            pass
        elif self._seen_missing:
            self._lose_server()
        else:
            # Once more, since a graph that is in motion may say so for a moment.
            self._seen_missing = True

    def close(self) -> None:
        """Leave; goals that run go on running."""
        self._clients.destroy()

    # --- sending ----------------------------------------------------------------------------

    def _open(self, goal: RosGoal) -> RosGoal:
        self._waiting[goal] = time.monotonic() + self._server_timeout_s
        self._send_waiting()
        return goal

    def _has_waited(self, seconds: float, now: float) -> bool:
        since = (until - self._server_timeout_s for until in self._waiting.values())
        return any(now - since_s >= seconds for since_s in since)

    def _send_waiting(self) -> None:
        if self._waiting and self.available:
            waiting, self._waiting = self._waiting, {}
            for goal in waiting:
                self._start(goal)

    def _start(self, goal: RosGoal) -> None:
        try:
            if goal.adopted:
                self._ask(goal, is_check=True)
                self._repeat_cancel(goal)
            else:
                self._request(goal)
        except ValueError as error:
            self._end(goal, GoalStatus.REJECTED, message=f'not sent: {error}')
        except Exception as error:  # noqa: BLE001 - rclpy's and the middleware's errors
            report(self._logger)
            self._end(goal, GoalStatus.REJECTED, message=f'cannot be sent: {error}')
        else:
            goal.heard_s = time.monotonic()
            goal.next_check_s = goal.heard_s + RESULT_CHECK_S
            self._in_flight[goal] = None
            self._expect(goal)

    def _expect(self, goal: RosGoal) -> None:
        self._client.expect(goal.id, partial(self._on_listed, goal))

    def _request(self, goal: RosGoal) -> None:
        message = self._class.Goal()
        fill(message, goal.request.args)
        if self._type.has_task_field:
            fill(message, {TASK: self._task_value(goal.request.task)})
        goal.response = self._client.send_goal_async(
            message, feedback_callback=partial(self._on_feedback, goal), goal_uuid=goal.id
        )
        goal.response.add_done_callback(partial(self._on_response, goal))

    def _task_value(self, task: str) -> Any:
        if task not in self._type.constants:
            raise ValueError(f'{self._type.name} has no task {task}')
        return self._type.constants[task]

    # --- what comes back --------------------------------------------------------------------

    def _on_response(self, goal: RosGoal, response: Any) -> None:
        with _Guard(self, goal):
            accepted = bool(response.result().accepted)
            if goal.end is not None:
                self._on_late_response(goal, response, accepted)
            elif not accepted:
                # It may have this UUID already: then it is no rejection (semantics 9.2).
                goal.refused = True
                self._ask(goal, is_check=True)
            else:
                self._on_accepted(goal)

    def _on_listed(self, goal: RosGoal, runs: bool) -> None:
        goal.listed = True
        if runs or not goal.adopted:
            self._on_accepted(goal)

    def _on_accepted(self, goal: RosGoal) -> None:
        if goal.accepted or goal.end is not None:
            return
        self._accept(goal)
        self._ask(goal, is_check=False)
        self._repeat_cancel(goal)

    def _on_late_response(self, goal: RosGoal, response: Any, accepted: bool) -> None:
        if response in self._unanswered:
            self._unanswered.remove(response)
        if accepted and goal.end is not None and goal.end.status in _GIVEN_UP:
            text = f'goal {goal.request.id} was accepted after it was given up; it is cancelled'
            self._logger.warning(text)
            self._client.request_cancel(goal.id)

    def _on_result(self, goal: RosGoal, is_check: bool, response: Any) -> None:
        with _Guard(self, goal):
            if goal.end is not None:
                return
            if response.status in _ENDS:
                goal.accepted = True
                status = _ENDS[response.status]
                self._end(goal, status, result=to_plain(response.result))
            elif response.status == WireStatus.STATUS_UNKNOWN and is_check:
                self._on_unknown(goal)

    def _on_unknown(self, goal: RosGoal) -> None:
        goal.heard_s = time.monotonic()
        goal.unknown_count += 1
        believed = 1 if goal.accepted else REQUEST_CHECKS
        if goal.refused:
            self._end(goal, GoalStatus.REJECTED, message='refused by the server')
        elif goal.unknown_count >= believed:
            message = f'the server does not know the goal (any more){self._listed_end(goal)}'
            self._lose(goal, message, self._denier(goal))
        else:
            goal.denied_by = self._client.server_id()

    def _denier(self, goal: RosGoal) -> str | None:
        """Return which server does not know a goal, if it was there at both answers."""
        there = self._client.server_id()
        return there if there == goal.denied_by else None

    def _on_feedback(self, goal: RosGoal, message: Any) -> None:
        if goal.end is None:
            goal.keep_feedback(self._now(), message.feedback)

    # --- loss -------------------------------------------------------------------------------

    def _ask(self, goal: RosGoal, *, is_check: bool) -> None:
        """Ask for the result.

        :param is_check: whether the server must know the goal by now; the question that follows
            an acceptance at once may overtake the server's own book-keeping
        """
        self._client.ask_result(goal.id, partial(self._on_result, goal, is_check))

    def _check(self) -> None:
        now = time.monotonic()
        for goal in [goal for goal in self._in_flight if goal.next_check_s <= now]:
            goal.next_check_s += RESULT_CHECK_S
            if self._may_be_silent(goal):
                goal.heard_s = now
            elif now - goal.heard_s >= SILENCE_S and goal.renewed:
                self._give_up(goal)
                continue
            elif now - goal.heard_s >= SILENCE_S:
                self._renew()
            if not goal.accepted or goal.renewed:
                self._repeat_cancel(goal)
            self._ask(goal, is_check=True)

    def _may_be_silent(self, goal: RosGoal) -> bool:
        """Tell whether a server may leave a question about a goal open (semantics 9.3).

        It may while its status says of any goal that it runs, and if it accepted this one and has
        no status.
        """
        return self._client.is_busy or (goal.accepted and not goal.listed)

    def _renew(self) -> None:
        text = f'{self._component.action} does not answer; it is asked through a fresh participant'
        self._logger.warning(text)
        if self._clients.may_be_renewed:
            self._clients.renew()
        now = time.monotonic()
        for goal in self._in_flight:
            goal.renewed = True
            goal.heard_s = now
            self._expect(goal)
            self._client.follow(goal.id, partial(self._on_feedback, goal))

    def _give_up(self, goal: RosGoal) -> None:
        server = f'the server of {self._component.action}'
        message = f'{server} is there and does not answer{self._listed_end(goal)}'
        self._end(goal, GoalStatus.SILENT, message=message)

    def _listed_end(self, goal: RosGoal) -> str:
        """Return what else is known of a goal whose result does not come."""
        end = self._client.listed_end(goal.id)
        return f'; its status topic says that the goal {end}' if end else ''

    def _repeat_cancel(self, goal: RosGoal) -> None:
        """Cancel a goal by its UUID, since no acceptance may ever come."""
        if goal.cancel_requested:
            self._client.request_cancel(goal.id)

    def _lose_server(self) -> None:
        for goal in tuple(self._in_flight):
            self._lose(goal, f'the server of {self._component.action} is gone')
        for response in self._unanswered:
            self._clients.forget_request(response)
        self._unanswered.clear()
        self._client.forget_cancels()

    def _lose(self, goal: RosGoal, message: str, denied_by: str | None = None) -> None:
        self._end(goal, GoalStatus.LOST, message=message, denied_by=denied_by)

    # --- book-keeping -----------------------------------------------------------------------

    def _accept(self, goal: RosGoal) -> None:
        goal.accepted = True
        self._news.add(goal)
        # Now, while the goal runs, rather than before the next one, which somebody waits for.
        now = time.monotonic()
        if self._server is None or now - self._server_seen_s >= SERVER_LOOK_S:
            self._server, self._server_seen_s = self._client.server_id(), now

    def _end(
        self,
        goal: RosGoal,
        status: GoalStatus,
        *,
        result: Any = None,
        message: str = '',
        denied_by: str | None = None,
    ) -> None:
        self._waiting.pop(goal, None)
        self._in_flight.pop(goal, None)
        self._clients.forget(goal.id)
        if goal.response is not None and not goal.response.done():
            if status in _GIVEN_UP:
                self._remember_unanswered(goal.response)
            else:  # an answer that was lost on its way
                self._clients.forget_request(goal.response)
        goal.end = GoalEnd(status, result or {}, message, denied_by)
        self._news.add(goal)

    def _remember_unanswered(self, response: Any) -> None:
        self._unanswered.append(response)
        if len(self._unanswered) > _MOST_UNANSWERED:
            self._clients.forget_request(self._unanswered.pop(0))

    def fail(self, goal: RosGoal, error: BaseException) -> None:
        """End a goal about which something came that cannot be handled: nobody knows its end."""
        report(self._logger)
        if goal.end is None:
            self._lose(goal, f'error while handling the answer of the server: {error}')


class _Guard:
    """Turns an exception in a callback about a goal into the end of the goal."""

    def __init__(self, link: ActionLink, goal: RosGoal) -> None:
        self._link = link
        self._goal = goal

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> bool:
        if isinstance(error, Exception):
            self._link.fail(self._goal, error)
            return True
        return False
