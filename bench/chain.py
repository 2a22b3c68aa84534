"""The floor: what somebody writes by hand in rclpy for one fixed line. No journal, no failures."""

from __future__ import annotations

import sys
from typing import Any

import rclpy
from bt_orchestrator_interfaces.action import Component, Conveyor
from rclpy.action.client import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future

from bench.line_files import SECTIONS
from bt_orchestrator.ros.executor.executors import make_executor, spin_once
from bt_orchestrator.ros.executor.ways import lean_way

PLAIN = 'plain'


class Chain(Node):
    """Two tasks in each section, side by side; then the belt; and again."""

    def __init__(self, cycles: int) -> None:
        super().__init__('chain')
        self._left = cycles
        self._working = 0
        self.done = False
        self._stations: list[list[Any]] = [
            [ActionClient(self, Component, f'/bench/{x}{n}') for x in 'ab']
            for n in range(1, SECTIONS + 1)
        ]
        self._belt: Any = ActionClient(self, Conveyor, '/bench/belt')

    def ready(self) -> bool:
        """Tell whether every server is there."""
        clients = [*(c for station in self._stations for c in station), self._belt]
        return all(client.server_is_ready() for client in clients)

    def cycle(self) -> None:
        """Begin a cycle, or end."""
        if self._left == 0:
            self.done = True
            return
        self._left -= 1
        self._working = SECTIONS
        for station in self._stations:
            self._work(list(station))

    def _work(self, clients: list[Any]) -> None:
        if clients:
            goal = Component.Goal(task=Component.Goal.TASK_A)
            _perform(clients[0], goal, lambda: self._work(clients[1:]))
            return
        self._working -= 1
        if self._working == 0:
            _perform(self._belt, Conveyor.Goal(task=Conveyor.Goal.MOVE_ONE_INDEX), self.cycle)


def _perform(client: Any, goal: Any, then: Any) -> None:
    def accepted(response: Future[Any]) -> None:
        handle: Any = response.result()
        handle.get_result_async().add_done_callback(lambda _: then())

    client.send_goal_async(goal).add_done_callback(accepted)


def main() -> None:
    """Run: chain EXECUTOR CYCLES; EXECUTOR is PLAIN, rclpy's own, or one of the tree node's."""
    rclpy.init()
    kind = sys.argv[1]
    chain = Chain(int(sys.argv[2]))
    is_plain = kind == PLAIN
    executor = SingleThreadedExecutor() if is_plain else make_executor(kind, lean_way(chain))
    executor.add_node(chain)
    while not chain.ready():
        spin_once(executor, 0.05)
    print('ready: chain', flush=True)
    sys.stdin.readline()
    chain.cycle()
    while not chain.done:
        spin_once(executor)
    print('done', flush=True)
    sys.stdin.readline()


if __name__ == '__main__':
    main()
