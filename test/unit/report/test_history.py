"""What became of jobs, as their records tell: the same counts as the state, and more."""

from __future__ import annotations

from fakes.drawn.lines import lines
from fakes.drawn.plan import Plan
from fakes.line import THREE, Line, with_section
from fakes.plan_runs import ProductBench, operate
from fakes.profiles import examples
from hypothesis import given

from bt_orchestrator.model.jobs.job_record import (
    Counts,
    JobRecord,
    job_from_plain,
    job_to_plain,
    record_of,
)
from bt_orchestrator.report.history import FOLLOWED, History


def history_of(records: list[dict[str, object]]) -> History:
    history = History()
    for record in records:
        history.follow(record)
    return history


@examples(12, 100)
@given(lines())
def test_it_counts_what_the_state_counts_and_needs_some_records_only(plan: Plan) -> None:
    bench = ProductBench(plan)
    operate(bench, plan.moments)
    state, records = bench.run.state, bench.run.records
    jobs = history_of(records).jobs
    assert jobs.keys() == state.ended.keys() | state.jobs.keys()
    for name, ended in state.ended.items():
        kept, job = record_of(ended), jobs[name]
        assert job.counts == kept.counts
        assert (job.queued, job.started, job.ended) == (kept.queued, kept.started, kept.ended)
        assert (job.status, job.script, job.quantity) == (kept.status, kept.script, kept.quantity)
    some = [record for record in records if record['event'] in FOLLOWED]
    assert history_of(some).jobs == jobs


def test_items_results_and_failures() -> None:
    line = Line(faults={'a2': '#2=abort'}, results={'a2': {'measurement': 2.5}})
    text = with_section(2, '- {id: work, @a2, continue_if_fail: true}')
    run = line.run(text, 2)
    job = history_of(run.records).jobs['J']
    good, bad = job.items.values()
    assert good.results['work']['measurement'] == 2.5
    assert 'work' not in bad.results
    assert (good.how, bad.how, bad.nonconforming) == ('packed', 'packed', ['work'])
    (failure,) = job.failures
    assert (failure.item, failure.task, failure.reason) == ('J/2', 'work', 'aborted')
    assert job.counts == Counts(started=2, placed=2, packed=2, nonconforming=1)


def test_a_job_on_the_line() -> None:
    run = Line().begin(THREE, 2)
    run.go(until=1.5)
    job = history_of(run.records).jobs['J']
    assert (job.status, job.ended, job.items['J/1'].how) == ('running', None, '')


def test_a_summary_comes_back_and_stands_for_a_job_without_its_beginning() -> None:
    (ended,) = Line().run(THREE, 2).state.ended.values()
    kept = record_of(ended)
    assert job_from_plain(job_to_plain(kept)) == kept
    history = History([record_of(ended)])
    history.follow({'event': 'item.placed', 'job': 'J', 'item': 'J/2', 'time': 1.0})
    assert history.jobs['J'] == kept
    history.follow({'event': 'job.queued', 'job': 'J', 'script': 's', 'quantity': 1, 'time': 9.0})
    assert history.jobs['J'] == JobRecord('J', 's', 1, 9.0)
