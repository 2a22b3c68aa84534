"""The checks that need ROS 2, on nodes and servers of the test's own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest
import rclpy
from action_msgs.msg import GoalStatusArray
from bt_orchestrator_interfaces.msg import Status
from cell_processes import SMALL_CELL, remembering
from rclpy.context import Context
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import Bool, String
from test_msgs.action import Fibonacci
from thread_servers import ThreadServers

from bt_orchestrator.base.diagnosis.check import Check, Verdict
from bt_orchestrator.cli import doctor
from bt_orchestrator.ros.diagnosis.cell_check import cell_on_graph, tree_node
from bt_orchestrator.ros.diagnosis.graph import Graph
from bt_orchestrator.ros.diagnosis.participant import exchange
from bt_orchestrator.ros.types.action_types import InstalledActionTypes
from bt_orchestrator.script.cell_file import parse_cell

TIMEOUT_S = 10.0
SHORT_S = 0.5
SETTLE_S = 1.0

CELL = """
cell: looked_at
conveyor: {sections: 1, action: belt, type: test_msgs/action/Fibonacci}
components:
  arm:
    section: 1
    action: arm
    type: test_msgs/action/Fibonacci
    state: {topic: arm/state, type: std_msgs/msg/String, field: data, ready: [READY]}
"""

LATCHED = QoSProfile(
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)


def serve(servers: ThreadServers, *names: str) -> None:
    for name in names:
        servers.serve(name, Fibonacci, lambda goal: Fibonacci.Result())


def looked(timeout_s: float, elsewhere: str = '') -> dict[str, Check]:
    cell = parse_cell(CELL, 'cell.yaml', InstalledActionTypes())
    with Graph('/', SETTLE_S) as graph:
        return {check.name: check for check in cell_on_graph(graph, cell, timeout_s, elsewhere)}


def test_a_cell_that_is_complete(servers: ThreadServers) -> None:
    serve(servers, 'belt', 'arm')
    servers.node.create_publisher(String, 'arm/state', LATCHED)
    assert {name: (c.verdict, c.found) for name, c in looked(TIMEOUT_S).items()} == {
        'conveyor: action server': (Verdict.OK, '/belt (/thread_servers)'),
        'arm: action server': (Verdict.OK, '/arm (/thread_servers)'),
        'arm: state topic': (Verdict.OK, '/arm/state (/thread_servers)'),
    }


def test_wholly_wrong_cell_fails_every_check(servers: ThreadServers) -> None:
    serve(servers, 'arm', 'arm')
    servers.node.create_publisher(Bool, 'arm/state', 10)
    checks = looked(SHORT_S, elsewhere='there are nodes in 42')
    assert {check.verdict for check in checks.values()} == {Verdict.FAIL}
    assert checks['conveyor: action server'].found == 'none at /belt'
    assert checks['conveyor: action server'].remedy.startswith('there are nodes in 42; start')
    finding = checks['arm: action server'].found
    assert finding.startswith('2 servers at /arm: /thread_servers (id ')
    assert finding.count('/thread_servers (id ') == 2, 'equal names are told apart'
    assert checks['arm: state topic'].found == (
        '/arm/state is std_msgs/msg/Bool (/thread_servers), not std_msgs/msg/String'
    )


def test_status_publisher_without_server_fails_the_check(servers: ThreadServers) -> None:
    serve(servers, 'belt', 'arm')
    servers.node.create_publisher(String, 'arm/state', LATCHED)
    context = Context()
    rclpy.init(context=context)
    intruder = Node('intruder', context=context)
    try:
        intruder.create_publisher(GoalStatusArray, '/arm/_action/status', LATCHED)
        check = looked(TIMEOUT_S)['arm: action server']
    finally:
        intruder.destroy_node()
        context.try_shutdown()
    assert check.verdict is Verdict.FAIL
    assert check.found == '/intruder publishes the status of /arm and takes no goals'


def test_a_server_of_another_type(servers: ThreadServers) -> None:
    from bt_orchestrator_interfaces.action import Component

    serve(servers, 'belt')
    servers.serve('arm', Component, lambda goal: Component.Result())
    checks = looked(SHORT_S)
    check = checks['arm: action server']
    assert check.verdict is Verdict.FAIL
    assert 'is bt_orchestrator_interfaces/action/Component (/thread_servers), not' in check.found
    assert checks['arm: state topic'].found == 'no node publishes /arm/state'


@pytest.mark.parametrize(
    ('profile', 'word'),
    [
        (QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT), 'BEST_EFFORT'),
        (QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE), 'VOLATILE'),
    ],
)
def test_a_state_topic_that_may_be_missed(
    servers: ThreadServers, profile: QoSProfile, word: str
) -> None:
    serve(servers, 'belt', 'arm')
    servers.node.create_publisher(String, 'arm/state', profile)
    check = looked(TIMEOUT_S)['arm: state topic']
    assert check.verdict is Verdict.WARN
    assert check.found == f'/arm/state is {word} at /thread_servers'


# --- tree node and clock ----------------------------------------------------------------------


def about_node(name: str, *, expected: bool = True) -> dict[str, Check]:
    with Graph('/', SETTLE_S) as graph:
        checks = tree_node(graph, name, expected=expected, timeout_s=TIMEOUT_S)
        return {check.name: check for check in checks}


def test_a_node_that_runs_alone(servers: ThreadServers) -> None:
    checks = about_node('/thread_servers')
    assert checks['tree node'].found == '/thread_servers runs'
    assert checks['clock'] == Check('clock', Verdict.OK, 'of the computer')


@pytest.mark.parametrize(('role', 'verdict'), [('engineer', Verdict.OK), ('view', Verdict.WARN)])
def test_the_role_of_everybody_is_told(
    servers: ThreadServers, role: str, verdict: Verdict
) -> None:
    publisher = servers.node.create_publisher(Status, '/thread_servers/status', LATCHED)
    publisher.publish(Status(unauthenticated_role=role))
    check = about_node('/thread_servers')['role over ROS']
    assert check.verdict is verdict
    assert f'unauthenticated: everybody in the ROS domain has the role {role}' in check.found


def test_7_12_where_signatures_are_required_that_is_told(servers: ThreadServers) -> None:
    publisher = servers.node.create_publisher(Status, '/thread_servers/status', LATCHED)
    publisher.publish(Status(unauthenticated_role='view', signed_commands='required'))
    check = about_node('/thread_servers')['role over ROS']
    assert check.verdict is Verdict.OK
    assert 'only requests that a key has signed count' in check.found


def test_two_nodes_of_one_name(servers: ThreadServers) -> None:
    with closing(ThreadServers()):
        check = about_node('/thread_servers')['tree node']
    assert (check.verdict, check.found) == (
        Verdict.FAIL,
        '2 nodes are called /thread_servers',
    )


def test_simulated_time_that_nobody_publishes(servers: ThreadServers) -> None:
    from rclpy.parameter import Parameter

    servers.node.set_parameters([Parameter('use_sim_time', value=True)])
    check = about_node('/thread_servers')['clock']
    assert (check.verdict, check.found) == (
        Verdict.FAIL,
        '/thread_servers has use_sim_time, but no node publishes /clock',
    )


def test_a_node_that_is_missing() -> None:
    with Graph('/', SETTLE_S) as graph:
        (missing, _), (free, _) = (
            list(tree_node(graph, '/gone', expected=expected, timeout_s=SHORT_S))
            for expected in (True, False)
        )
    assert (missing.verdict, free.verdict) == (Verdict.FAIL, Verdict.OK)


# --- discovery --------------------------------------------------------------------------------


def test_two_processes_find_each_other_and_talk() -> None:
    times = exchange({}, patience_s=TIMEOUT_S)
    assert times.found is not None
    assert times.answered is not None
    assert not times.broken


def test_two_processes_that_may_not_find_each_other() -> None:
    assert exchange({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'OFF'}, patience_s=1.0).found is None


def test_processes_that_cannot_start() -> None:
    times = exchange({'ROS_LOG_DIR': '/proc/self/log'}, patience_s=1.0)
    assert times.found is None
    assert 'log directory' in times.broken


# --- the verb ---------------------------------------------------------------------------------


def run_doctor(*words: str | Path, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, '-m', 'bt_orchestrator', 'doctor', *map(str, words)],
        capture_output=True,
        text=True,
        timeout=50,
        env={**os.environ, **environment},
        check=False,
    )


def test_a_machine_without_a_cell_is_fine(tmp_path: Path) -> None:
    done = run_doctor('--json', '--journal', tmp_path / 'journal.db')
    assert done.returncode == 0, done.stdout + done.stderr
    report = json.loads(done.stdout)
    verdicts = {check['name']: check['verdict'] for check in report['checks']}
    assert report['verdict'] in ('ok', 'warn')
    assert {'rclpy', 'middleware', 'discovery', 'tree node', 'journal folder'} <= set(verdicts)
    assert verdicts['discovery'] == 'ok'


def test_what_is_wrong_is_said_with_its_remedy(tmp_path: Path) -> None:
    cell = tmp_path / 'cell.yaml'
    cell.write_text(CELL.replace('test_msgs/action/Fibonacci', 'tset_msgs/action/Fibonacci'))
    done = run_doctor('--cell', cell, RMW_IMPLEMENTATION='rmw_nix')
    assert (done.returncode, done.stderr) == (1, '')
    assert f'fail  cell file: {cell}:3:' in done.stdout
    assert 'the package tset_msgs is not installed' in done.stdout
    assert 'fail  middleware: cannot be loaded: ' in done.stdout
    assert '\n      -> install the package that RMW_IMPLEMENTATION names' in done.stdout


def test_9_4_a_standby_needs_servers_that_remember(tmp_path: Path) -> None:
    address = 'postgresql://line@db.plant.invalid/plant/line_1'
    cell = tmp_path / 'cell.yaml'
    for text, verdict in ((SMALL_CELL, 'warn'), (remembering(SMALL_CELL), 'ok')):
        cell.write_text(text)
        done = run_doctor('--json', '--cell', cell, '--journal', address)
        checks = {check['name']: check['verdict'] for check in json.loads(done.stdout)['checks']}
        assert checks['result_timeout'] == verdict
        assert checks['journal database'] == 'fail', 'no such host'


def test_lines_of_a_check() -> None:
    assert list(doctor.lines(Check('clock', Verdict.OK, 'set'))) == ['ok    clock: set']
    assert list(doctor.lines(Check('a', Verdict.WARN, 'b', 'c'))) == ['warn  a: b', '      -> c']
