"""An action server that never answers a question for a result, in a process of its own or not.

    python test/mute_server.py ACTION

It serves the example type, accepts every goal and ends it at once, until it is killed.
"""

from __future__ import annotations

import signal
import sys
from typing import Any

import rclpy
from rclpy.action.server import ActionServer
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

READY = 'serving: '


class MuteServer(ActionServer):  # type: ignore[type-arg] # no Generic in Jazzy's rclpy
    """Keeps its results, and whether it knows a goal, to itself."""

    async def _execute_get_result_request(self, request_header_and_message: Any) -> None:
        """Do not answer."""


def main() -> None:
    """Serve until killed, or for longer than any test takes."""
    from bt_orchestrator_interfaces.action import Component

    def execute(handle: Any) -> Any:
        handle.succeed()
        return Component.Result(task_result=True)

    signal.alarm(600)
    rclpy.init()
    node = Node('mute_server')
    server = MuteServer(node, Component, sys.argv[1], execute)
    print(f'{READY}{sys.argv[1]}')  # noqa: T201 - for the parent process
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    executor.spin()
    server.destroy()


if __name__ == '__main__':
    main()
