"""The convention: a py_trees tree polled at a rate, with one action client a leaf."""

from __future__ import annotations

import sys
from typing import Any

import py_trees
import rclpy
from bt_orchestrator_interfaces.action import Component, Conveyor
from py_trees.common import ParallelPolicy, Status
from rclpy.action.client import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from bench.line_files import SECTIONS


class Leaf(py_trees.behaviour.Behaviour):
    """Sends its goal when it is entered, and asks its futures at each tick."""

    def __init__(self, node: Node, kind: Any, action: str, goal: Any) -> None:
        super().__init__(action)
        self.client: Any = ActionClient(node, kind, action)
        self._goal = goal
        self._response: Any = None
        self._result: Any = None

    def initialise(self) -> None:
        """Send the goal."""
        self._result = None
        self._response = self.client.send_goal_async(self._goal)
        self._response.add_done_callback(self._accepted)

    def update(self) -> Status:
        """Say whether the result has come."""
        done = self._result is not None and self._result.done()
        return Status.SUCCESS if done else Status.RUNNING

    def _accepted(self, response: Any) -> None:
        self._result = response.result().get_result_async()


def tree(node: Node) -> tuple[py_trees.behaviour.Behaviour, list[Leaf]]:
    """Build the line: stations side by side, then the belt."""
    work = Component.Goal(task=Component.Goal.TASK_A)
    leaves = {
        n: [Leaf(node, Component, f'/bench/{x}{n}', work) for x in 'ab']
        for n in range(1, SECTIONS + 1)
    }
    belt = Leaf(node, Conveyor, '/bench/belt', Conveyor.Goal(task=Conveyor.Goal.MOVE_ONE_INDEX))
    stations = [
        py_trees.composites.Sequence(f'section {n}', memory=True, children=list(two))
        for n, two in leaves.items()
    ]
    every = ParallelPolicy.SuccessOnAll(synchronise=True)
    cycle = py_trees.composites.Parallel('sections', every, list(stations))
    root = py_trees.composites.Sequence('cycle', memory=True, children=[cycle, belt])
    return root, [*(leaf for two in leaves.values() for leaf in two), belt]


def main() -> None:
    """Run: polling_tree PERIOD_S CYCLES."""
    rclpy.init()
    node, executor = Node('polling_tree'), SingleThreadedExecutor()
    executor.add_node(node)
    root, leaves = tree(node)
    left = int(sys.argv[2])
    while not all(leaf.client.server_is_ready() for leaf in leaves):
        executor.spin_once(timeout_sec=0.05)
    print('ready: tree', flush=True)
    sys.stdin.readline()

    def tick() -> None:
        nonlocal left
        root.tick_once()
        left -= root.status is Status.SUCCESS

    timer = node.create_timer(float(sys.argv[1]), tick)
    while left > 0:
        executor.spin_once()
    timer.cancel()
    print('done', flush=True)
    sys.stdin.readline()


if __name__ == '__main__':
    main()
