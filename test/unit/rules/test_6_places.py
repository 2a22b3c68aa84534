"""Semantics 6.7: the place of an order by its priority and start; jobs that wait for theirs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest
from fakes.commands import Arrange, MoveJob, RunNext
from fakes.line import THREE, Line
from fakes.queued_jobs import LINE, SCRIPT, begun, queue
from fakes.virtual_run import BY, VirtualRun

from bt_orchestrator.model.cell import Start
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.model.jobs.job_commands import AddJobs, UpdateJob
from bt_orchestrator.model.jobs.order import NO_TERMS, Job, Terms
from bt_orchestrator.model.keeping.snapshot import state_from_plain, state_to_plain
from bt_orchestrator.model.limits import QUEUE_SHOWN
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.state.proposed import queue_digest

LATE = Terms(due=10.0)
ADVISORY = replace(LINE.cell, start=Start.ADVISORY)


def order(name: str, priority: int = 0, start: float | None = None) -> Job:
    return Job(name, SCRIPT, 1, terms=Terms(priority, start))


def give(run: VirtualRun, *jobs: Job, position: int | None = None, held: bool = False) -> Answer:
    answer = run.ask(AddJobs(jobs, BY, position, held))
    assert answer.accepted, answer
    return answer


def line_with(*jobs: Job) -> VirtualRun:
    """Return a line on which J runs, with other jobs behind it; a start is no more than advice."""
    run = VirtualRun(ADVISORY, LINE.types)
    run.submit('J', SCRIPT, 3)
    for job in jobs:
        give(run, job)
    return run


# --- places ---------------------------------------------------------------------------------


def test_6_7_ordinary_orders_are_put_at_the_end() -> None:
    run = line_with(*map(order, 'KLM'))
    assert queue(run) == 'KLM'
    assert [record.get('position') for record in run.all('job.queued')] == [None] * 4


def test_6_7_queue_sorts_by_priority_then_arrival() -> None:
    run = line_with(*map(order, 'KL'), order('A', 5), order('B', 5), order('C', 7), order('D', 6))
    assert queue(run) == 'CDABKL'
    give(run, order('E', -1), order('F'), order('G', -2))
    assert queue(run) == 'CDABKLFEG'
    run.go()
    assert begun(run) == list('JCDABKLFEG')


def test_6_7_equal_priorities_sort_by_start_time() -> None:
    run = line_with(order('K'), order('L', 0, 90.0), order('M', 0, 60.0), order('N', 0, 90.0))
    assert queue(run) == 'MLNK'
    give(run, order('O', 1))
    assert queue(run) == 'OMLNK', 'priority is compared first'


def test_6_7_orders_given_together_sort_one_by_one() -> None:
    batch = line_with(*map(order, 'KL'), order('A', 5))
    jobs = [order('B', 5), order('C'), order('D', 9), order('E', 5), order('F', 9), order('G', 1)]
    give(batch, *jobs)
    each = line_with(*map(order, 'KL'), order('A', 5), *jobs)
    assert queue(batch) == queue(each) == 'DFABEGKLC'


def test_6_7_the_place_is_decided_once_and_recorded() -> None:
    run = line_with(*map(order, 'KL'), order('A', 5))
    (record,) = run.all('job.queued', job='A')
    assert (record['position'], record['ranked']) == (1, True)


def test_6_7_less_urgent_orders_pass_no_moved_job() -> None:
    run = line_with(*map(order, 'KLM'))
    run.ask(MoveJob('M', 1, BY))
    give(run, order('A', 5))
    assert queue(run) == 'MAKL'
    run.ask(RunNext('L', BY))
    give(run, order('B', 9))
    assert queue(run) == 'LMBAK'


def test_6_7_order_passes_moved_job_behind_less_urgent_one() -> None:
    run = line_with(*map(order, 'KLM'))
    run.ask(MoveJob('K', 3, BY))
    assert queue(run) == 'LMK'
    give(run, order('A', 5), order('B'))
    assert queue(run) == 'ALMKB'


def test_6_7_position_given_with_order_counts_as_move() -> None:
    run = line_with(*map(order, 'KL'))
    give(run, order('X'), order('Y'), position=1)
    give(run, order('A', 5))
    assert queue(run) == 'XYAKL'


def test_6_7_order_goes_last_when_all_are_moved() -> None:
    run = line_with(*map(order, 'KL'))
    for name in 'KL':
        run.ask(MoveJob(name, 1, BY))
    give(run, order('A', 5))
    assert queue(run) == 'LKA'


def test_6_7_new_priority_or_start_changes_place() -> None:
    run = line_with(*map(order, 'KLM'), order('A', 5))
    assert run.ask(UpdateJob(order('M', 7), BY)).accepted
    assert queue(run) == 'MAKL'
    assert run.ask(UpdateJob(order('M', 5), BY)).accepted
    assert queue(run) == 'AMKL', 'as if it had come now'
    run.ask(UpdateJob(order('L', 0, 60.0), BY))
    assert queue(run) == 'AMLK'
    run.ask(UpdateJob(order('A'), BY))
    assert queue(run) == 'MLKA'
    assert run.all('job.updated', job='A')[0]['position'] == 4


def test_6_7_repositioned_job_ignores_its_old_place() -> None:
    run = line_with(*map(order, 'KLM'))
    run.ask(MoveJob('L', 2, BY))
    run.ask(UpdateJob(order('K', 5), BY))
    assert queue(run) == 'LKM'


def test_6_7_other_changes_and_moved_jobs_keep_place() -> None:
    run = line_with(*map(order, 'KLM'))
    run.ask(UpdateJob(replace(order('K'), quantity=2), BY))
    run.ask(MoveJob('L', 3, BY))
    run.ask(UpdateJob(order('L', 9), BY))
    assert queue(run) == 'KML'
    assert not any('position' in record for record in run.all('job.updated'))


def test_6_7_jobs_of_an_older_program_keep_their_places() -> None:
    run = line_with(*map(order, 'KL'))
    for job in run.state.jobs.queue():
        assert job.ranked
    older = state_to_plain(run.state)
    for plain in older['objects']:
        if isinstance(plain, dict):
            plain.pop('ranked', None)
    state = state_from_plain(ADVISORY, older)
    assert [job.ranked for job in state.jobs.queue()] == [False, False]
    assert state.jobs.place_for(Terms(9).urgency) == 3


# --- an order that was proposed -------------------------------------------------------------


def arrange(run: VirtualRun, order: str, digest: str | None = None) -> Answer:
    seen_digest = queue_digest(run.state.jobs) if digest is None else digest
    return run.ask(Arrange(order, seen_digest, BY))


def test_6_7_proposed_order_is_recorded_once_and_followed() -> None:
    run = line_with(*map(order, 'KLM'))
    assert arrange(run, 'MKL').message == 'the order of the queue is M, K, L'
    assert queue(run) == 'MKL'
    (record,) = run.all('queue.arranged')
    assert record['jobs'] == ['M', 'K', 'L']
    (decided,) = run.all('operator.decided', answer='arrange')
    assert (decided['who'], decided['seq']) == ('Ann', record['seq'] - 1)
    run.go()
    assert begun(run) == list('JMKL')


def test_6_7_later_orders_are_sorted_into_proposed_order() -> None:
    run = line_with(order('K', 2), order('L'), order('M', 0, 60.0), order('N', 0, 90.0))
    assert queue(run) == 'KMNL'
    assert arrange(run, 'LKNM').accepted
    give(run, order('A', 1), order('B', 0, 70.0), order('C'), order('D', 9))
    assert queue(run) == 'DABLKNMC', 'before the first that is less urgent, else at the end'
    assert run.ask(UpdateJob(order('M', 3), BY)).accepted
    assert queue(run) == 'DMABLKNC'


def test_6_7_changed_queue_refuses_proposed_order() -> None:
    changes: dict[str, Callable[[VirtualRun], object]] = {
        'N came': lambda run: give(run, order('N')),
        'K left it': lambda run: run.control('cancel', 'K'),
        'an order, a hold or a place': lambda run: run.control('hold', 'L'),
        'an order,': lambda run: run.ask(UpdateJob(replace(order('L'), quantity=2), BY)),
        'an order, a': lambda run: run.ask(UpdateJob(replace(order('L'), terms=LATE), BY)),
        'a place in it is another one': lambda run: run.ask(MoveJob('K', 1, BY)),
        'another one; propose': lambda run: run.ask(MoveJob('K', 2, BY)),
    }
    for what, change in changes.items():
        run = line_with(*map(order, 'KLM'))
        digest = queue_digest(run.state.jobs)
        change(run)
        before = queue(run)
        refused = arrange(run, 'MKL', digest)
        assert not refused.accepted
        assert refused.message.startswith('the queue has changed since: '), refused
        assert what in refused.message
        assert queue(run) == before


def test_6_7_proposal_names_each_job_and_keeps_moves() -> None:
    run = line_with(*map(order, 'KLM'))
    assert arrange(run, 'MK').message == 'jobs are K, L, M, each once, in the new order'
    assert arrange(run, 'MKK').message == 'jobs are K, L, M, each once, in the new order'
    assert arrange(run, 'KLM').message == 'the queue is in this order'
    run.ask(MoveJob('L', 2, BY))
    assert arrange(run, 'LKM').message == 'L stays at place 2, which a person chose; use move'
    assert arrange(run, 'MLK').accepted
    assert queue(run) == 'MLK'
    assert [job.ranked for job in run.state.queue] == [True, False, True]


def test_6_7_first_jobs_of_long_queue_are_arranged() -> None:
    run = line_with(*(order(f'Q{number:03}') for number in range(QUEUE_SHOWN + 3)))
    first = [job.job.id for job in run.state.queue[:QUEUE_SHOWN]]
    digest = queue_digest(run.state.jobs)
    give(run, order('late'))
    assert run.ask(Arrange(first[::-1], digest, BY)).accepted, 'behind them one may come'
    names = [job.job.id for job in run.state.queue]
    assert names == [*first[::-1], 'Q100', 'Q101', 'Q102', 'late']


# --- start ----------------------------------------------------------------------------------


def waiting() -> VirtualRun:
    """Return a line on which J runs, with W behind it that waits until 60 s, and K."""
    run = VirtualRun(LINE.cell, LINE.types)
    run.submit('J', SCRIPT, 3)
    give(run, order('K'))
    answer = give(run, order('W', 0, 60.0))
    assert answer.message == 'W is queued; it waits for its start, 1970-01-01 00:01:00 UTC'
    return run


def test_6_7_job_waits_for_its_start_while_others_pass() -> None:
    run = waiting()
    assert queue(run) == 'WK'
    run.go()
    assert begun(run) == list('JKW')
    assert run.times('job.may_start') == run.times('job.started', job='W') == [60.0]
    assert run.ended


def test_6_7_cell_is_complete_while_jobs_await_start() -> None:
    run = waiting()
    run.go(until=59.0)
    assert run.state.packml is PackmlState.COMPLETE
    run.go()
    assert run.ended
    assert run.states[-6:] == [
        'Resetting',
        'Idle',
        'Starting',
        'Execute',
        'Completing',
        'Complete',
    ]


def test_6_7_job_takes_its_place_when_start_comes() -> None:
    run = waiting()
    give(run, *(replace(order(name), quantity=9) for name in 'LMN'))
    run.go()
    started = begun(run)
    assert started.index('W') < started.index('N')
    assert started[:3] == list('JKL')


def test_6_7_status_shows_allowed_job_awaiting_start() -> None:
    run = waiting()
    status = {job.id: job for job in run.sim.status().jobs}
    assert status['W'].state is JobWord.ALLOWED_TO_START
    assert (status['W'].awaits_start, status['W'].start) == (True, 60.0)
    assert not status['K'].awaits_start


def test_6_7_past_start_is_not_awaited() -> None:
    run = VirtualRun(LINE.cell, LINE.types)
    run.submit('J', SCRIPT, 3)
    run.go(until=5.0)
    give(run, order('W', 0, run.now), order('V', 0, run.now - 1.0))
    assert not any(job.awaits_start for job in run.state.jobs.values())
    run.go()
    assert begun(run) == list('JVW')


def test_6_7_an_advisory_start_only_places_the_job() -> None:
    run = line_with(order('K'), order('W', 0, 60.0))
    assert queue(run) == 'WK'
    run.go()
    assert begun(run) == list('JWK')
    assert run.all('job.may_start') == []


def test_6_7_advisory_starts_let_waiting_jobs_start() -> None:
    run = waiting()
    state = state_from_plain(ADVISORY, state_to_plain(run.state))
    again = VirtualRun(ADVISORY, LINE.types)
    vars(again.sim.state).update(vars(state))
    again.sim.orchestrator.settle()
    assert again.state.jobs.first_awaiting is None


@pytest.mark.parametrize('command', ['release', 'next'])
def test_6_7_an_operator_need_not_wait(command: str) -> None:
    run = waiting()
    run.go(until=2.0)
    if command == 'next':
        assert run.ask(RunNext('W', BY)).accepted
    else:
        assert run.control('release', 'W').message == 'W is released'
    run.go()
    assert begun(run) == list('JWK')
    assert run.now < 60.0


def test_6_7_release_ends_hold_first_then_wait() -> None:
    run = waiting()
    assert run.control('hold', 'W').accepted
    first = run.control('release', 'W')
    assert first.message.endswith('UTC; release it again to let it start at once'), first
    assert run.state.jobs['W'].awaits_start
    assert run.control('release', 'W').accepted
    assert run.state.jobs['W'].may_start
    refused = run.control('release', 'W')
    assert 'W is AllowedToStart' in refused.message


def test_6_7_next_takes_hold_and_wait_away() -> None:
    run = waiting()
    run.control('hold', 'W')
    run.ask(RunNext('W', BY))
    assert run.state.jobs['W'].may_start


def test_6_7_held_job_stays_held_at_start_time() -> None:
    run = waiting()
    run.control('hold', 'W')
    run.go(until=100.0)
    assert begun(run) == list('JK')
    assert run.control('release', 'W').message == 'W is released'
    run.go()
    assert begun(run) == list('JKW')


def test_6_7_only_new_start_makes_job_wait() -> None:
    run = waiting()
    run.ask(UpdateJob(order('W', 0, 90.0), BY))
    run.go(until=70.0)
    assert begun(run) == list('JK')
    run.control('release', 'W')
    run.go()
    assert begun(run) == list('JKW')

    run = waiting()
    run.control('release', 'W')
    allowed = []
    for job in (replace(order('W', 3, 60.0), quantity=2), order('W', 3, 61.0), order('W', 3)):
        run.ask(UpdateJob(job, BY))
        allowed.append(run.state.jobs['W'].may_start)
    assert allowed == [True, False, True]


def test_6_7_waiting_job_can_be_aborted_or_cancelled() -> None:
    run = waiting()
    give(run, order('V', 0, 70.0))
    assert run.control('abort', 'W').accepted
    assert run.control('cancel', 'V').accepted
    run.go()
    assert begun(run) == list('JK')
    assert run.all('job.may_start') == []


def test_6_7_a_job_that_waits_prepares_nothing() -> None:
    line = Line()
    prepared = line.script(f'initialization: [{{id: ready, @lamp}}]{THREE}', 'prepared')
    run = VirtualRun(line.cell, line.types)
    run.submit('J', line.script(THREE), 1)
    run.ask(AddJobs((Job('W', prepared, 1, terms=Terms(start=60.0)),), BY))
    run.go()
    assert run.starts('ready') == [60.0]


def test_6_7_orders_without_terms_have_none() -> None:
    assert NO_TERMS.urgency == (0, float('inf'))
