"""What `queue propose` prints of a proposal."""

from __future__ import annotations

import pytest

from bt_orchestrator.cli.ordering.proposal import how_sure, lines
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.cli.what_if import _asked
from bt_orchestrator.ports import Proposal, ProposedJob

JOBS = (
    ProposedJob('first', 0, 0, 0, None, 5.0, 5.0),
    ProposedJob('B', 2, 1, 1, 1010.0, 25.0, 12.0),
    ProposedJob('A', 1, 2, 0, 1030.0, 12.0, 25.0),
    ProposedJob('C', 3, 3, 0, 1040.0, None, None, 'its place was chosen'),
)
FOUND = Proposal(JOBS, 'd1ge57', 15.0, 2.0, 2, 2, True, {'C': 'hold 1 waits'})


def test_jobs_show_places_ends_and_remarks() -> None:
    head, *rows, together, sure, stays, unknown, left = lines(FOUND, 1000.0, left_out=3)
    assert head.split() == [
        'job',
        'place',
        'now',
        'priority',
        'due',
        'in',
        'would',
        'end',
        'in',
        'now',
        'late',
        'now',
    ]
    assert [row.split() for row in rows] == [
        ['first', 'line', 'line', '0', '5.0', 's', '5.0', 's'],
        ['B', '1', '2', '1', '10.0', 's', '12.0', 's', '25.0', 's', '2.0', 's', '15.0', 's'],
        ['A', '2', '1', '0', '30.0', 's', '25.0', 's', '12.0', 's'],
        ['C', '3', '3', '0', '40.0', 's', 'unknown', 'unknown'],
    ]
    assert together == 'all jobs together: 2.0 s late; now 15.0 s'
    assert sure == 'it is the best of all 2 orders that keep priorities and the places that stay'
    assert stays == 'C stays: its place was chosen'
    assert unknown == 'C: the end is unknown, hold 1 waits'
    assert left == 'without the last 3 jobs of the queue, which keep their places'


def test_it_says_how_sure_it_is() -> None:
    assert how_sure(FOUND._replace(orders=1)).startswith('it is the only order that keep')
    some = how_sure(FOUND._replace(orders=40320, looked_at=41, is_best=False))
    assert some.startswith('it is the best of 41 orders looked at, of 40320 that keep')
    same = FOUND._replace(jobs=[job._replace(new_place=job.place) for job in JOBS])
    assert 'the queue stays unchanged' in list(lines(same, 1000.0))


def test_a_proposal_is_no_request_to_be_foreseen() -> None:
    with pytest.raises(WrongUse, match='asks nothing of the cell'):
        _asked('queue propose --apply')
