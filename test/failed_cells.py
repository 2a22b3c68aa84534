"""Beside a test that failed, how its cells stood: a wait that was over says not why."""

from __future__ import annotations

from collections.abc import Generator

import pytest
from cell_processes import CellProcesses

CELLS = pytest.StashKey[list[CellProcesses]]()
"""The cells that a test has started."""


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Ask the cells of a test that failed while they are still there."""
    report = yield
    if report.failed and report.when != 'teardown':
        for cell in item.stash.get(CELLS, []):
            report.sections.append((f'the cell in {cell.folder.name}', _account(cell)))
    return report


def _account(cell: CellProcesses) -> str:
    try:
        return cell.account()
    except Exception as error:  # noqa: BLE001 - the failure of the test must be reported all the same
        return f'it cannot be asked: {error!r}'
