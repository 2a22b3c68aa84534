"""A new user's story on a terminal: a hold answered with a key, a kill, a coffee, --resume."""

from __future__ import annotations

import os
import re
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import rclpy
import yaml
from action_msgs.msg import GoalStatus, GoalStatusArray
from program_process import DEMO_PACKED
from pseudo_terminal import PseudoTerminal
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSDurabilityPolicy, QoSProfile

from bt_orchestrator.cli.demo.folder import DemoFolder
from bt_orchestrator.cli.folders import shipped

FORGETS_S = 0.2
"""So soon the cell's servers forget, unless the demo tells them not to."""

COFFEE_S = 10 * FORGETS_S

AT_WORK = (GoalStatus.STATUS_ACCEPTED, GoalStatus.STATUS_EXECUTING, GoalStatus.STATUS_CANCELING)


@pytest.fixture
def cell(tmp_path: Path) -> Path:
    """Give the demo's cell with servers that forget at once."""
    content = yaml.safe_load(shipped('config', 'reference_cell.yaml').read_text())
    for component in (content['conveyor'], *content['components'].values()):
        component['result_timeout'] = FORGETS_S
    path = tmp_path / 'cell.yaml'
    path.write_text(yaml.safe_dump(content))
    return path


@pytest.fixture
def folder(tmp_path: Path) -> Iterator[Path]:
    """Give a folder for the demo; what is left running in it ends with the test."""
    path = tmp_path / 'demo folder'
    yield path
    with DemoFolder(path) as demo:
        demo.begin()


def actions(cell: Path) -> list[str]:
    content = yaml.safe_load(cell.read_text())
    return [device['action'] for device in (content['conveyor'], *content['components'].values())]


def let_goals_end(cell: Path) -> None:
    """Wait until no controller works, and for a coffee."""
    context = Context()
    rclpy.init(context=context)
    node = rclpy.create_node('onlooker', context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    heard: dict[str, GoalStatusArray] = {}
    latched = QoSProfile(depth=1, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
    for action in actions(cell):
        topic = f'{action}/_action/status'
        node.create_subscription(
            GoalStatusArray, topic, lambda m, a=action: heard.update({a: m}), latched
        )
    try:
        deadline = time.monotonic() + 60.0
        while len(heard) < len(actions(cell)) or any(map(_works, heard.values())):
            assert time.monotonic() < deadline, heard
            executor.spin_once(timeout_sec=0.1)
        end = time.monotonic() + COFFEE_S
        while time.monotonic() < end:
            executor.spin_once(timeout_sec=0.1)
    finally:
        executor.shutdown()
        node.destroy_node()
        rclpy.shutdown(context=context)


def _works(status: GoalStatusArray) -> bool:
    return any(goal.status in AT_WORK for goal in status.status_list)


def node_pid(terminal: PseudoTerminal) -> int:
    match = re.search(r'the tree node is process (\d+)', terminal.text)
    assert match, terminal.text
    return int(match[1])


@pytest.mark.long
def test_a_hold_a_kill_and_a_coffee(cell: Path, folder: Path) -> None:
    demo = ['demo', '--folder', str(folder)]
    first = PseudoTerminal(
        [*demo, '--cell', str(cell), '--speed', '2', '--fail', 'component_3a.#1=abort'], 100, 40
    )
    try:
        first.until_shows('press a key: 1 retry   2 mark_done   3 skip')
        first.until_shows('hold 1: section 4, 4.1 (TASK_A) of WO-1001/1 at component_3a')
        assert 'bt-orchestrator answer 1 retry --reason "WHY"' in first.text
        first.press('1')
        first.until_shows('1 of 3 packed')
        os.kill(node_pid(first), signal.SIGKILL)
        assert first.wait() == 1
        assert b'demo --resume --folder' in first.raw
        first.assert_left_clean()
    finally:
        first.close()
    let_goals_end(cell)

    second = PseudoTerminal([*demo, '--resume'], 100, 40)
    try:
        second.until_shows('the tree node is process')
        os.kill(node_pid(second), signal.SIGKILL)
        assert second.wait() == 1
    finally:
        second.close()

    third = PseudoTerminal([*demo, '--resume'], 100, 40)
    try:
        assert third.wait() == 0, third.text
        summary = third.raw.decode(errors='replace')
        assert re.search(DEMO_PACKED, summary)
    finally:
        third.close()
