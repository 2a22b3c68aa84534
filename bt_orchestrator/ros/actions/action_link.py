"""The connection to one action server: what goes out to it."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from itertools import chain
from typing import Any

from rclpy.node import Node

from bt_orchestrator.model.action_type import TASK, ActionType
from bt_orchestrator.model.cell import Component
from bt_orchestrator.model.goal import (
    WITHDRAWN,
    Contest,
    GoalEnd,
    GoalRequest,
    GoalStatus,
    SeenContest,
)
from bt_orchestrator.model.words import sentence
from bt_orchestrator.ports.news import News
from bt_orchestrator.ports.spare_log import report
from bt_orchestrator.ros.actions.fresh_participant import KEPT_FRESH_S, RenewableClient
from bt_orchestrator.ros.actions.goal_client import GoalClient
from bt_orchestrator.ros.actions.goal_follower import GoalFollower
from bt_orchestrator.ros.actions.open_goals import Leave, OpenGoals, RosGoal
from bt_orchestrator.ros.actions.rivals import RIVALS_FRESH_S, Rivals, Strangers
from bt_orchestrator.ros.actions.server_watch import ServerWatch
from bt_orchestrator.ros.executor.ways import Way
from bt_orchestrator.ros.types.messages import fill, to_plain

_SEEK_S = 3.0
"""Seconds without a server after which a fresh participant looks for it."""


class ActionLink:
    """One component's action client: sends goals once the server is there, and cancels them.

    What comes back is for `GoalFollower`, what does not for `ServerWatch`.
    """

    def __init__(
        self,
        node: Node,
        component: Component,
        action_class: Any,
        action_type: ActionType,
        news: News,
        server_timeout_s: float,
        fresh_node: Callable[[float], Node],
        leave: Leave,
        way: Way,
    ) -> None:
        """Make the client.

        :param fresh_node: returns a node with a participant so many seconds old at most
        :param leave: whether goals may be sent
        """
        self._leave = leave
        self._component = component.name
        self._action = component.action
        self._told = SeenContest(component.name, Contest())
        self._class = action_class
        self._type = action_type
        self._server_timeout_s = server_timeout_s
        self._logger = node.get_logger().get_child(component.name)
        self._clients = RenewableClient(
            node,
            lambda on: GoalClient(on, action_class, component.action, way),
            partial(fresh_node, KEPT_FRESH_S),
        )
        self._server = SeenServer(self._clients)
        self._goals = OpenGoals(self._clients, news)
        self._prepared: dict[str, RosGoal] = {}
        self._without_args: dict[str, Any] = {}
        """Messages of goals without arguments by task: they are written out when they are sent."""
        self._rivals = Rivals(self._clients, partial(fresh_node, RIVALS_FRESH_S))
        self._strangers = Strangers(self._clients, self._goals)
        self._follower = GoalFollower(
            self._clients, self._goals, self._rivals, self._logger, leave
        )
        self._watch = ServerWatch(
            self._action, self._clients, self._goals, self._follower, self._rivals, self._logger
        )

    @property
    def _client(self) -> GoalClient:
        return self._clients.current

    @property
    def nodes(self) -> Iterator[Node]:
        """Nodes that its clients use."""
        return chain(self._clients.nodes, self._rivals.nodes)

    @property
    def available(self) -> bool:
        """Tell whether the server is in the ROS graph."""
        return self._client.server_is_there()

    @property
    def server(self) -> str | None:
        """Id of the server's status publisher, as it was seen last."""
        return self._server.id

    @property
    def rivals(self) -> Sequence[str]:
        """All servers that are in the ROS graph, if several are; see `Rivals.glance`."""
        return self._rivals.glance()

    def look(self) -> SeenContest | None:
        """Look who is there, once a second; return what has changed since the last time."""
        self._rivals.look_afresh()
        self._server.look()
        seen = self._strangers.seen(self._component, self._rivals.look())
        if seen == self._told:
            return None
        self._told = seen
        return seen

    def forget(self) -> None:
        """Forget what was seen while another node led the cell."""
        self._told = SeenContest(self._component, Contest())
        self._strangers.forget()

    @property
    def is_waiting(self) -> bool:
        """Tell whether goals wait for the server."""
        return bool(self._goals.waiting)

    @property
    def is_open(self) -> bool:
        """Tell whether there is anything that `poll` or `watch` has to look after."""
        return self.is_waiting or self._goals.any_sent

    def prepare(self, request: GoalRequest) -> None:
        """Do ahead what takes long of a goal that may be sent in a moment: nothing is sent.

        What fails here fails again, and is told, when the goal is sent.
        """
        with suppress(Exception):
            self._rivals.look()
            goal = RosGoal(request, self)
            goal.message = self._message(request)
            self._prepared[request.id] = goal

    def send(self, request: GoalRequest) -> RosGoal:
        """Send a goal, or let it wait for the server."""
        prepared = self._prepared.pop(request.id, None)
        return self._open(RosGoal(request, self) if prepared is None else prepared)

    def adopt(self, request: GoalRequest) -> RosGoal:
        """Take over a goal that an earlier process sent (semantics 9.2)."""
        goal = RosGoal(request, self)
        goal.adopted = True
        return self._open(goal)

    def cancel(self, goal: RosGoal) -> None:
        """Pass a cancel request on, or withdraw a goal that was not sent."""
        if goal.end is not None:
            return
        goal.cancel_requested = True
        if goal in self._goals.waiting and not goal.adopted:
            end = GoalEnd(GoalStatus.CANCELED, message=WITHDRAWN, never_begun=True)
            self._goals.end_with(goal, end)
        elif goal.accepted or (goal.adopted and goal in self._goals.in_flight):
            self._client.request_cancel(goal.id)

    def feedback(self, goal: RosGoal) -> Mapping[str, Any] | None:
        """Return the last feedback of a goal, as plain values."""
        message = self._client.feedback(goal.id)
        return None if message is None else to_plain(message)

    def poll(self) -> None:
        """Send what waits, if the server has come; give up what waited too long."""
        self._send_waiting()
        now = time.monotonic()
        if not self.available and self._clients.may_be_renewed and self._has_waited(_SEEK_S, now):
            self._clients.renew()
        several = Contest(self._rivals.look()).words(self._action)
        seconds = f'{self._server_timeout_s:g}'
        message = several or sentence('no_server', action=self._action, seconds=seconds)
        for goal in [goal for goal, until in self._goals.waiting.items() if until <= now]:
            status = GoalStatus.LOST if goal.adopted else GoalStatus.UNAVAILABLE
            self._goals.end(goal, status, message=message)

    def watch(self) -> None:
        """Look after the goals in flight."""
        self._watch.look()

    def close(self) -> None:
        """Leave; goals that run go on running."""
        self._clients.destroy()

    def _open(self, goal: RosGoal) -> RosGoal:
        self._goals.waiting[goal] = time.monotonic() + self._server_timeout_s
        self._send_waiting()
        return goal

    def _has_waited(self, seconds: float, now: float) -> bool:
        since = (until - self._server_timeout_s for until in self._goals.waiting.values())
        return any(now - since_s >= seconds for since_s in since)

    def _send_waiting(self) -> None:
        if not self._goals.waiting or not self.available:
            return
        several = self._rivals.look()
        for goal in tuple(self._goals.waiting):
            # What was sent before is asked for; nothing new goes to two servers.
            if goal.adopted or not (several or not self._leave.may_send()):
                del self._goals.waiting[goal]
                self._start(goal)

    def _start(self, goal: RosGoal) -> None:
        try:
            if goal.adopted:
                self._follower.ask(goal, is_check=True)
                self._follower.repeat_cancel(goal)
            else:
                self._request(goal)
        except ValueError as error:
            self._goals.end(goal, GoalStatus.REJECTED, message=sentence('not_sent', words=error))
        except Exception as error:  # noqa: BLE001 - rclpy's and the middleware's errors
            report(self._logger)
            self._goals.end(goal, GoalStatus.REJECTED, message=f'cannot be sent: {error}')
        else:
            self._watch.begin(goal)

    def _request(self, goal: RosGoal) -> None:
        message = goal.message or self._message(goal.request)
        answered = partial(self._follower.on_response, goal)
        goal.question = self._client.send(message, goal.id, answered)

    def _message(self, request: GoalRequest) -> Any:
        if not request.args and request.task in self._without_args:
            return self._without_args[request.task]
        message = self._class.Goal()
        fill(message, request.args)
        if self._type.has_task_field:
            fill(message, {TASK: self._task_value(request.task)})
        if not request.args:
            self._without_args[request.task] = message
        return message

    def _task_value(self, task: str) -> Any:
        if task not in self._type.constants:
            raise ValueError(f'{self._type.name} has no task {task}')
        return self._type.constants[task]


# The instance of the server.


class SeenServer:
    """The id of the server's status publisher, as it was seen last."""

    def __init__(self, clients: RenewableClient) -> None:
        self._clients = clients
        self._id: str | None = None

    @property
    def id(self) -> str | None:
        """The id; None: no server was there, or more than one."""
        if self._id is None:
            self.look()
        return self._id

    def look(self) -> None:
        """Look again; to be called once a second."""
        self._id = self._clients.current.status.publisher_id()
