"""Every fault of a real action server: its reason, and what the policy makes of it."""

from __future__ import annotations

import pytest
from cell_processes import CellProcesses, run_verb


def start(start_cell: object, *faults: str, **options: object) -> CellProcesses:
    cell = start_cell(fail=[f'worker.{fault}' for fault in faults], **options)  # type: ignore[operator]
    assert isinstance(cell, CellProcesses)
    cell.connect(wait_servers=False)
    return cell


def starts(cell: CellProcesses) -> list[int]:
    return [event['attempt'] for event in cell.watch.seen('task.started', task='work')]


def assert_packed(cell: CellProcesses, *, nonconforming: int = 0) -> None:
    job = cell.watch.until_ended('WO-1')
    assert (job.packed, job.nonconforming, job.rejected) == (1, nonconforming, 0)
    cell.stop()


@pytest.mark.parametrize(
    ('fault', 'reason'),
    [
        ('TASK_A=reject', 'goal_rejected'),
        ('TASK_A=abort', 'aborted'),
        ('TASK_A=cancel', 'canceled'),
        ('TASK_A=false', 'task_result_false'),
    ],
)
def test_a_failed_attempt_is_repeated(start_cell: object, fault: str, reason: str) -> None:
    cell = start(start_cell, fault)
    cell.watch.wait_servers()
    cell.run_small(', retries: 1')

    assert_packed(cell)
    assert cell.watch.reasons('work') == [reason]
    assert starts(cell) == [1, 2]
    assert [e['attempt'] for e in cell.watch.seen('task.retrying')] == [2]
    assert not cell.watch.seen('hold.raised')
