"""What the methods of job control answer; the table as a whole is in test_isa95_table.py."""

from __future__ import annotations

import pytest

from bt_orchestrator.extensions.opcua.mes.methods import (
    REQUESTS,
    STORING,
    TABLE,
    refused,
)
from bt_orchestrator.model.jobs import job_control
from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.model.jobs.job_control import METHODS, Method
from bt_orchestrator.view.report.isa95.codes import ReturnStatus

DONE, UNKNOWN, WRONG = ReturnStatus.DONE, ReturnStatus.UNKNOWN_ID, ReturnStatus.WRONG_STATE


def test_an_order_is_stored_once() -> None:
    for method in STORING:
        new, *others = (cell.status for cell in TABLE[method])
        assert new is DONE
        assert set(others) == {ReturnStatus.NOT_ACCEPTED}


def test_other_methods_reject_unknown_job() -> None:
    others = [cells[0].status for method, cells in TABLE.items() if method not in STORING]
    assert set(others) == {UNKNOWN}


@pytest.mark.parametrize(
    ('method', 'word', 'ending', 'status'),
    [
        (job_control.STOP, JobWord.RUNNING, 'stopping', WRONG),
        (job_control.ABORT, JobWord.RUNNING, 'stopping', ReturnStatus.NOT_ACCEPTED),
        (job_control.START, JobWord.NOT_ALLOWED_TO_START, '', ReturnStatus.NOT_ACCEPTED),
        (job_control.START, JobWord.RUNNING, '', WRONG),
        (job_control.START, None, '', UNKNOWN),
        (job_control.STORE, JobWord.ENDED, '', ReturnStatus.NOT_ACCEPTED),
    ],
)
def test_refusal_distinguishes_unknown_job_from_wrong_state(
    method: Method, word: JobWord | None, ending: str, status: ReturnStatus
) -> None:
    assert refused(method, word, ending) == status


def test_every_method_is_a_request_of_the_table() -> None:
    assert [request.name for request in map(REQUESTS.__getitem__, METHODS)] == [
        'queue.add',
        'queue.add',
        'job.release',
        'job.hold',
        'job.update',
        'job.pause',
        'job.resume',
        'job.stop',
        'job.abort',
        'job.cancel',
        'job.clear',
    ]
