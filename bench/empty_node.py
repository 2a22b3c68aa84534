"""What an idle node costs that only has a timer of 10 Hz and eleven action clients."""

from __future__ import annotations

from typing import Any

import rclpy
from bt_orchestrator_interfaces.action import Component, Conveyor
from rclpy.action.client import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from bench.line_files import SECTIONS


def main() -> None:
    """Run until killed."""
    rclpy.init()
    node = Node('empty')
    names = [f'/bench/{letter}{n}' for n in range(1, SECTIONS + 1) for letter in 'ab']
    clients: list[Any] = [ActionClient(node, Component, name) for name in names]
    clients.append(ActionClient(node, Conveyor, '/bench/belt'))
    node.create_timer(0.1, lambda: None)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    print('ready: empty', flush=True)
    executor.spin()


if __name__ == '__main__':
    main()
