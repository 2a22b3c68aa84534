"""Methods of jobs, compared with the table that is written from the standard."""

from __future__ import annotations

import pytest
from isa95_table import GONE, NONE, Cell, read_table

from bt_orchestrator.mes.methods import (
    DIFFERENT,
    REQUESTS,
    STATES,
    STORING,
    TABLE,
    Answered,
    refused,
)
from bt_orchestrator.mes.return_status import ReturnStatus
from bt_orchestrator.model.jobs import job_control
from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.model.jobs.job_control import METHODS, Method

DONE, UNKNOWN, WRONG = ReturnStatus.DONE, ReturnStatus.UNKNOWN_ID, ReturnStatus.WRONG_STATE

STANDARD = read_table()


def test_the_88_cells_are_those_of_the_standard_but_where_it_is_said() -> None:
    ours = {
        (method.name, word.value if word else NONE): Cell(int(cell.status), _after(method, cell))
        for method, cells in TABLE.items()
        for word, cell in zip(STATES, cells, strict=True)
    }
    different = {(method.name, word.value) for method, word in DIFFERENT}
    assert len(ours) == 88
    assert ours.keys() == STANDARD.keys()
    assert {key for key in ours if ours[key] != STANDARD[key]} == {('Resume', 'Interrupted/Held')}
    later = {key for key in different if ours[key] == STANDARD[key]}
    assert later == different - {('Resume', 'Interrupted/Held')}


def test_only_the_states_that_wait_for_the_line_to_drain_come_later() -> None:
    later = {
        (method, word)
        for method, cells in TABLE.items()
        for word, cell in zip(STATES, cells, strict=True)
        if cell.is_later
    }
    assert later == set(DIFFERENT) - {(job_control.RESUME, JobWord.HELD)}


def _after(method: Method, cell: Answered) -> str:
    if cell.status is not DONE:
        return ''
    return GONE if cell.after is None else cell.after.state


def test_an_order_is_stored_once() -> None:
    for method in STORING:
        new, *others = (cell.status for cell in TABLE[method])
        assert new is DONE
        assert set(others) == {ReturnStatus.NOT_ACCEPTED}


def test_nothing_else_can_be_asked_of_a_job_that_is_not_there() -> None:
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
def test_a_refusal_says_whether_the_job_or_its_state_is_the_cause(
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
