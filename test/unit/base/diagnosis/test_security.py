"""What is said where security of DDS is asked for and cannot be had."""

from __future__ import annotations

from pathlib import Path

from bt_orchestrator.base.diagnosis.check import Verdict
from bt_orchestrator.base.diagnosis.ros_environment import ros_says, security

ON = {'ROS_SECURITY_ENABLE': 'true'}
ENFORCED = ON | {'ROS_SECURITY_STRATEGY': 'Enforce'}


def test_security_that_is_not_asked_for_is_off() -> None:
    assert security({}).verdict is Verdict.OK
    assert 'any participant may command the cell' in security({}).found


def test_missing_keys_warn_or_fail_when_enforced(tmp_path: Path) -> None:
    for more in ({}, {'ROS_SECURITY_KEYSTORE': str(tmp_path)}):
        assert security(ON | more).verdict is Verdict.WARN
        assert security(ENFORCED | more).verdict is Verdict.FAIL


def test_security_with_keys_is_on(tmp_path: Path) -> None:
    (tmp_path / 'enclaves').mkdir()
    check = security(ENFORCED | {'ROS_SECURITY_KEYSTORE': str(tmp_path)})
    assert check.verdict is Verdict.OK


def test_what_ros_says_without_a_word_is_explained(tmp_path: Path) -> None:
    error = RuntimeError('failed to initialize rcl: error not set')
    message = ros_says(error, ENFORCED)
    assert 'ROS_SECURITY_KEYSTORE is not set' in message
    assert 'unset ROS_SECURITY_ENABLE' in message
    (tmp_path / 'enclaves').mkdir()
    message = ros_says(error, ENFORCED | {'ROS_SECURITY_KEYSTORE': str(tmp_path)})
    assert message.startswith('ROS 2 says: failed to initialize rcl: error not set; ')
    assert 'may be built without security' in message
    assert ros_says(error, {}) == 'ROS 2 says: failed to initialize rcl: error not set'
