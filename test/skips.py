"""In CI a test that is skipped is a failure, unless its reason stands here.

A gate whose tests are skipped for want of a program is green and says nothing.
"""

from __future__ import annotations

import os

import pytest

ALLOWED = (
    # Rights that a container may not give.
    'needs root',
    'network namespaces need root',
    'this machine has no systemd',
    'this machine makes no network namespaces',
    # One of each pair runs on every distribution.
    'this rclpy has no events executor',
    'this rclpy has the events executor',
)
"""Beginnings of reasons."""

_reasons: list[str] = []


def is_allowed(reason: str) -> bool:
    return reason.removeprefix('Skipped: ').startswith(ALLOWED)


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Note a skipped test; where tests are shared out, the process that prints hears of all."""
    if report.skipped and not hasattr(report, 'wasxfail'):
        _note(report.nodeid, report.longrepr)


def pytest_collectreport(report: pytest.CollectReport) -> None:
    """Note a file that was skipped whole."""
    if report.skipped:
        _note(report.nodeid, report.longrepr)


def _note(test: str, longrepr: object) -> None:
    reason = str(longrepr[2] if isinstance(longrepr, tuple) else longrepr)
    if not is_allowed(reason):
        _reasons.append(f'{test}: {reason}')


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session) -> None:
    """Fail an otherwise green session."""
    if os.environ.get('CI') and _reasons and session.exitstatus == pytest.ExitCode.OK:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Say which."""
    if os.environ.get('CI') and _reasons:
        terminalreporter.section('skipped, and not on the list of test/skips.py')
        for line in _reasons:
            terminalreporter.write_line(line)
