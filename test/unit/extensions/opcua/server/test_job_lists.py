"""Which jobs are listed, when there are more than clients can take in."""

from __future__ import annotations

import pytest

from bt_orchestrator.extensions.opcua.server.job_control.lists import MOST, chosen
from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.model.status import JobStatus, ListedJob


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
    ('there', 'listed'),
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
def test_the_line_is_listed_first_then_the_last_that_ended_then_the_queue(
    there: tuple[int, int, int], listed: tuple[int, int, int]
) -> None:
    found = [job.status.id for job in chosen(map(ListedJob, jobs(*there)))]
    assert len(found) <= MOST
    counts = tuple(sum(id_.startswith(kind) for id_ in found) for kind in 'ELQ')
    assert counts == listed
    ended, line, queued = listed
    assert found[:ended] == [f'E{n}' for n in range(there[0] - ended, there[0])]
    assert found[ended + line :] == [f'Q{n}' for n in range(queued)]
