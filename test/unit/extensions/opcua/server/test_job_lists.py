"""Which jobs are listed, when there are more than clients can take in, and how they are sent."""

from __future__ import annotations

from dataclasses import replace
from unittest.mock import Mock

import pytest
from asyncua.ua.ua_binary import variant_to_binary

from bt_orchestrator.extensions.opcua.server.job_control.lists import MOST, JobLists, chosen
from bt_orchestrator.extensions.opcua.server.job_control.structures import (
    Structures,
    encoded,
    listed,
)
from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.model.status import JobStatus, ListedJob
from bt_orchestrator.view.report.isa95.codes import states_of
from bt_orchestrator.view.report.isa95.job_order import job_order
from bt_orchestrator.view.report.isa95.job_response import has_response, response_of


def jobs(ended: int, line: int, queued: int) -> list[JobStatus]:
    """Return jobs as a status lists them: those on the line, the queue, the last that ended."""
    return [
        *(JobStatus(f'L{n}', 's', JobWord.RUNNING) for n in range(line)),
        *(
            JobStatus(f'Q{n}', 's', JobWord.ALLOWED_TO_START, position=n + 1)
            for n in range(queued)
        ),
        *(JobStatus(f'E{n}', 's', JobWord.ENDED) for n in range(ended)),
    ]


@pytest.mark.parametrize(
    ('there', 'taken'),
    [
        ((0, 0, 0), (0, 0, 0)),
        ((3, 2, 4), (3, 2, 4)),
        ((100, 0, 0), (100, 0, 0)),
        ((100, 2, 10), (88, 2, 10)),
        ((100, 2, 100), (30, 2, 68)),
        ((5, 2, 100), (5, 2, 93)),
        ((100, 120, 100), (0, 100, 0)),
        ((100, 90, 100), (10, 90, 0)),
    ],
)
def test_line_takes_priority_over_ended_and_queued_jobs(
    there: tuple[int, int, int], taken: tuple[int, int, int]
) -> None:
    ids = [job.status.id for job in chosen(map(ListedJob, jobs(*there)))]
    assert len(ids) <= MOST
    counts = tuple(sum(id_.startswith(kind) for id_ in ids) for kind in 'ELQ')
    assert counts == taken
    ended, line, queued = taken
    assert ids[:ended] == [f'E{n}' for n in range(there[0] - ended, there[0])]
    assert ids[ended + line :] == [f'Q{n}' for n in range(queued)]


def test_a_list_is_sent_as_its_structures_are(structures: Structures) -> None:
    known = [*map(ListedJob, jobs(2, 2, 2))]
    orders = [
        structures.order_and_state(job_order(job), states_of(job.status.state)) for job in known
    ]
    responses = [
        structures.response(response_of(job, 'held')) for job in known if has_response(job.status)
    ]
    made = JobLists(structures)
    assert variant_to_binary(made.orders(known)) == variant_to_binary(listed(orders))
    assert variant_to_binary(made.responses(known, 'held')) == variant_to_binary(listed(responses))


def test_only_a_job_that_has_changed_is_encoded(
    structures: Structures, monkeypatch: pytest.MonkeyPatch
) -> None:
    encode = Mock(wraps=encoded)
    monkeypatch.setattr(f'{JobLists.__module__}.encoded', encode)
    known, made = [*map(ListedJob, jobs(0, 0, MOST))], JobLists(structures)
    made.orders(known)
    assert encode.call_count == MOST
    made.orders(known)
    known[7] = replace(known[7], status=replace(known[7].status, priority=5))
    made.orders(known)
    assert encode.call_count == MOST + 1
