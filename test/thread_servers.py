"""Action servers and publishers of any type, in a thread and a ROS context of their own."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable
from typing import Any

import rclpy
from rclpy.action.server import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.context import Context
from rclpy.exceptions import InvalidHandle
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future


class LateYes:
    """Decides on goals of such a server, but not before it is told to."""

    def __init__(self) -> None:
        self._told: Future[None] = Future()

    async def decide(self, goal: Any) -> GoalResponse:
        """Wait, for `ThreadServers.serve`."""
        await self._told
        return GoalResponse.ACCEPT

    def say(self) -> None:
        """Accept the goals that were asked for, and all that come."""
        self._told.set_result(None)


class ThreadServers:
    """States: serving, closed. Cancel requests are accepted."""

    def __init__(self) -> None:
        self._context = Context()
        rclpy.init(context=self._context)
        self.node = Node('thread_servers', context=self._context)
        self._executor = MultiThreadedExecutor(num_threads=3, context=self._context)
        self._executor.add_node(self.node)
        self._servers: list[Any] = []
        self._is_closing = False
        # A coroutine that waits is looked at only when the executor has something to do.
        self.node.create_timer(0.05, lambda: None)
        self._thread = threading.Thread(target=self._spin)
        self._thread.start()

    def serve(
        self,
        name: str,
        action_class: Any,
        execute: Callable[[Any], Any],
        decide: Callable[[Any], Any] = lambda goal: GoalResponse.ACCEPT,
        kind: Callable[..., Any] = ActionServer,
    ) -> None:
        """Start an action server.

        :param execute: gets the goal handle, returns the result
        :param decide: gets the goal; a coroutine may take its time while other callbacks run
        :param kind: class of the server
        """
        server = kind(
            self.node,
            action_class,
            name,
            execute_callback=execute,
            goal_callback=decide,
            cancel_callback=lambda goal: CancelResponse.ACCEPT,
            callback_group=ReentrantCallbackGroup(),
        )
        self._servers.append(server)

    def close(self) -> None:
        """Leave ROS."""
        self._is_closing = True
        self._executor.shutdown()
        self._thread.join()
        self.close_servers()
        self.node.destroy_node()
        self._context.shutdown()

    def close_servers(self) -> None:
        """Serve nothing any more."""
        for server in self._servers:
            server.destroy()
        self._servers.clear()

    def _spin(self) -> None:
        with contextlib.suppress(ExternalShutdownException):
            try:
                self._executor.spin()
            except InvalidHandle:  # a callback ended while the executor was shut down
                if not self._is_closing:
                    raise
