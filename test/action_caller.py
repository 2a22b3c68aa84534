"""An action client for tests, which waits for conditions and not for time."""

from __future__ import annotations

import time
import uuid
from collections.abc import Callable
from typing import Any

import rclpy
from patience import PATIENCE_S
from rclpy.action import ActionClient  # type: ignore[attr-defined] # not in its __all__
from rclpy.action.client import ClientGoalHandle
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from unique_identifier_msgs.msg import UUID

from bt_orchestrator.ros.qos import SERVICES


class ActionCaller:
    """A node with action clients; everything runs in the caller's thread."""

    def __init__(self) -> None:
        self._context = Context()
        rclpy.init(context=self._context)
        self.node = Node('action_caller', context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._clients: dict[str, Any] = {}
        self._known: set[Any] = set()

    def close(self) -> None:
        """Leave ROS."""
        for client in self._clients.values():
            client.destroy()
        self._executor.shutdown()
        self.node.destroy_node()
        self._context.shutdown()

    def spin_until(self, condition: Callable[[], Any], what: str) -> None:
        """Let callbacks run until a condition holds; fails, saying what was expected."""
        if not self.spin_for(PATIENCE_S, condition):
            raise AssertionError(f'waited {PATIENCE_S:.0f} s for {what}')

    def spin_for(self, seconds: float, unless: Callable[[], Any] = lambda: False) -> bool:
        """Let callbacks run for some time, or until a condition holds; return whether it does."""
        deadline = time.monotonic() + seconds
        while not unless():
            left_s = deadline - time.monotonic()
            if left_s <= 0:
                return False
            self._executor.spin_once(timeout_sec=min(left_s, 0.1))
        return True

    def client(self, action: str, action_class: Any) -> Any:
        """Return the client of an action; it may not have found its server yet."""
        if action not in self._clients:
            self._clients[action] = ActionClient(
                self.node,
                action_class,
                action,
                goal_service_qos_profile=SERVICES,
                result_service_qos_profile=SERVICES,
                cancel_service_qos_profile=SERVICES,
            )
        return self._clients[action]

    def request(
        self,
        action: str,
        action_class: Any,
        goal: Any,
        on_feedback: Callable[[Any], None] | None = None,
    ) -> Any:
        """Send a goal once its server is there; return the future of the goal handle."""
        client = self._known_client(action, action_class)
        return client.send_goal_async(goal, feedback_callback=on_feedback)

    def _known_client(self, action: str, action_class: Any) -> Any:
        """Return the client of an action, once its server is there and answers it."""
        client = self.client(action, action_class)
        self.spin_until(client.server_is_ready, f'the server of {action}')
        self._be_known(client, action)
        return client

    def _be_known(self, client: Any, action: str) -> None:
        """Wait until a server answers a client: at first it may not have found it whole.

        It learns of what a client is made of in order, so a question about a goal that does not
        exist, once answered, says that it can answer all others.
        """
        if client in self._known:
            return
        nothing = _handle(client, uuid.uuid4())  # all zeros would cancel every goal of the server

        def is_answered() -> bool:
            return self.spin_for(1.0, nothing.cancel_goal_async().done)

        self.spin_until(is_answered, f'{action} to answer anything')
        self._known.add(client)

    def wait(self, future: Any, what: str) -> Any:
        """Return what a future brings."""
        self.spin_until(future.done, what)
        return future.result()

    def start(self, action: str, action_class: Any, goal: Any, **options: Any) -> Any:
        """Send a goal and return its handle, once it is answered."""
        return self.wait(
            self.request(action, action_class, goal, **options), f'{action} to answer'
        )

    def result(self, handle: Any) -> Any:
        """Return the end of a goal, with `status` and `result`."""
        return self.wait(handle.get_result_async(), 'the result')

    def call(self, action: str, action_class: Any, goal: Any, **options: Any) -> Any:
        """Send a goal and return its end, with `status` and `result`."""
        return self.result(self.start(action, action_class, goal, **options))

    def cancel_of_another(self, action: str, action_class: Any, goal: str) -> Any:
        """Ask a server to cancel a goal that another client has sent; return its response.

        :param goal: its UUID, as text
        """
        client = self._known_client(action, action_class)
        asked = _handle(client, uuid.UUID(goal)).cancel_goal_async()
        return self.wait(asked, f'{action} to answer a cancel request')


def _handle(client: Any, goal: uuid.UUID) -> ClientGoalHandle[Any, Any, Any]:
    """Return the handle of a goal that this client need not have sent."""
    response = client._action_type.Impl.SendGoalService.Response(accepted=True)
    return ClientGoalHandle(client, UUID(uuid=list(goal.bytes)), response)
