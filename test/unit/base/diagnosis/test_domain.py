"""What the variables of discovery mean, alone and together."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_orchestrator.base.diagnosis.check import Verdict
from bt_orchestrator.base.diagnosis.ros_environment import (
    domain,
    domain_id,
    domains_in_use,
    is_local,
    keep_to_this_computer,
    name_ros_wheels,
    other_domains,
    reach,
)

OK, WARN, FAIL = Verdict.OK, Verdict.WARN, Verdict.FAIL

SOCKETS = """\
   sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode
  346: 00000000:1CE8 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 1 2 0 0
  356: 0100007F:45F6 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 1 2 0 0
  357: 00000000:1DE3 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 1 2 0 0
  400: 00000000:0035 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 1 2 0 0
  401: 00000000:F230 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 1 2 0 0
"""
"""Ports 7400 (domain 0), 17910 (42, a participant), 7651 (1, but nobody's), 53, and 62000."""


@pytest.mark.parametrize(
    ('text', 'verdict', 'number'),
    [
        (None, OK, 0),
        ('', OK, 0),
        ('42', OK, 42),
        ('101', OK, 101),
        ('102', WARN, 102),
        ('232', WARN, 232),
        ('233', FAIL, 233),
        ('-1', FAIL, 0),
        ('a', FAIL, 0),
    ],
)
def test_domain(text: str | None, verdict: Verdict, number: int) -> None:
    environment = {} if text is None else {'ROS_DOMAIN_ID': text}
    assert domain(environment).verdict is verdict
    assert domain_id(environment) == number


@pytest.mark.parametrize(
    ('variables', 'verdict', 'words'),
    [
        ({}, OK, 'SUBNET: every computer of the network'),
        ({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}, OK, 'LOCALHOST: this computer only'),
        (
            {'ROS_DISCOVERY_SERVER': '10.0.0.1:11811', 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'OFF'},
            OK,
            'whoever the discovery server at 10.0.0.1:11811 knows',
        ),
        (
            {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'OFF'},
            FAIL,
            'OFF: no other program, not even on this computer',
        ),
        ({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'localhost'}, WARN, "'localhost' is not a range"),
        ({'ROS_LOCALHOST_ONLY': '0'}, OK, 'SUBNET: every computer of the network'),
        (
            {'ROS_LOCALHOST_ONLY': '1', 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET'},
            WARN,
            'ROS_LOCALHOST_ONLY=1: this computer only, whatever the other variables say',
        ),
        (
            {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST', 'ROS_STATIC_PEERS': '10.0.0.2;cell7'},
            OK,
            'LOCALHOST: this computer only, and 10.0.0.2, cell7',
        ),
    ],
)
def test_reach(variables: dict[str, str], verdict: Verdict, words: str) -> None:
    check = reach(variables)
    assert (check.verdict, check.found) == (verdict, words)


@pytest.mark.parametrize(
    ('variables', 'message', 'is_near'),
    [
        ({}, 'LOCALHOST', True),
        ({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}, 'LOCALHOST', True),
        ({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'OFF'}, 'OFF', True),
        ({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET'}, 'SUBNET', False),
        ({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SYSTEM_DEFAULT'}, 'SYSTEM_DEFAULT', False),
        ({'ROS_LOCALHOST_ONLY': '1', 'ROS_STATIC_PEERS': '10.0.0.2'}, None, True),
        ({'ROS_LOCALHOST_ONLY': '0'}, None, False),
        ({'ROS_STATIC_PEERS': '10.0.0.2'}, None, False),
        (
            {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST', 'ROS_STATIC_PEERS': '10.0.0.2'},
            'LOCALHOST',
            False,
        ),
        ({'ROS_DISCOVERY_SERVER': '10.0.0.2:11811'}, None, False),
    ],
)
def test_who_keeps_to_this_computer(
    variables: dict[str, str], message: str | None, *, is_near: bool
) -> None:
    keep_to_this_computer(variables)
    assert variables.get('ROS_AUTOMATIC_DISCOVERY_RANGE') == message
    assert is_local(variables, 'rmw_fastrtps_cpp') is is_near
    assert not is_local(variables, 'rmw_zenoh_cpp')


def test_domains_that_others_are_in() -> None:
    assert domains_in_use(SOCKETS) == {0, 42}


def test_other_domains_are_named_for_a_hint(tmp_path: Path) -> None:
    sockets = tmp_path / 'udp'
    assert other_domains(0, sockets) == ''
    sockets.write_text(SOCKETS)
    assert other_domains(0, sockets) == (
        'this shell is in domain 0, and there are nodes on this computer in 42'
    )
    assert other_domains(7, sockets).endswith('in 0, 42')


def test_alone_in_the_only_domain(tmp_path: Path) -> None:
    sockets = tmp_path / 'udp'
    sockets.write_text('\n'.join(SOCKETS.splitlines()[:2]))
    assert other_domains(0, sockets) == ''


@pytest.fixture
def wheels(tmp_path: Path) -> Path:
    """Give the folder of an environment with ROS 2 from wheels."""
    index = tmp_path / 'share' / 'ament_index' / 'resource_index' / 'packages'
    index.mkdir(parents=True)
    (index / 'rclpy').touch()
    packages = tmp_path / 'lib' / 'python3.12' / 'site-packages'
    (packages / 'ros_jazzy_rclpy-7.1.6.dist-info').mkdir(parents=True)
    (packages / 'ros_rclpy-7.1.6.dist-info').mkdir()
    return tmp_path


def test_ros_wheels_are_found_without_a_setup_script(wheels: Path) -> None:
    environment: dict[str, str] = {}
    name_ros_wheels(environment, str(wheels))
    assert environment == {'AMENT_PREFIX_PATH': str(wheels), 'ROS_DISTRO': 'jazzy'}


def test_an_overlay_stays_before_the_wheels(wheels: Path) -> None:
    environment = {'AMENT_PREFIX_PATH': '/opt/line', 'ROS_DISTRO': 'kilted'}
    for _ in range(2):
        name_ros_wheels(environment, str(wheels))
        expected = {'AMENT_PREFIX_PATH': f'/opt/line:{wheels}', 'ROS_DISTRO': 'kilted'}
        assert environment == expected


def test_without_ros_wheels_nothing_is_set(tmp_path: Path) -> None:
    environment: dict[str, str] = {}
    name_ros_wheels(environment, str(tmp_path))
    assert environment == {}
