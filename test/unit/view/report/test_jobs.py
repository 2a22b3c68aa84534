"""The records of jobs and items: the same counts as the state, and more."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

from fakes.drawn.lines import lines
from fakes.drawn.plan import Plan
from fakes.line import THREE, Line, with_section
from fakes.plan_operator import operate
from fakes.plan_runs import ProductBench
from fakes.profiles import examples
from fakes.virtual_run import BY
from hypothesis import given

from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import json_of, known_event
from bt_orchestrator.model.jobs.job_commands import AddJobs, UpdateJob
from bt_orchestrator.model.jobs.job_record import (
    Counts,
    JobRecord,
    job_from_plain,
    job_to_plain,
    record_of,
)
from bt_orchestrator.model.jobs.order import Job, Terms
from bt_orchestrator.view.report.ended_jobs import FOLLOWED, JobFold


def jobs_of(records: Iterable[Mapping[str, Any]], *known: JobRecord) -> Mapping[str, JobRecord]:
    fold = JobFold(known)
    for record in records:
        event = known_event(record)
        if event is not None:
            fold.follow(event)
    return fold.jobs


@examples(12, 100)
@given(lines())
def test_job_fold_matches_state_from_followed_records(plan: Plan) -> None:
    bench = ProductBench(plan)
    operate(bench, plan.moments)
    state, records = bench.run.state, bench.run.records
    jobs = jobs_of(records)
    assert jobs.keys() == state.ended.keys() | state.jobs.keys()
    for name, ended in state.ended.items():
        kept, job = record_of(ended), jobs[name]
        assert job.counts == kept.counts
        assert (job.queued, job.started, job.ended) == (kept.queued, kept.started, kept.ended)
        assert (job.status, job.script, job.quantity) == (kept.status, kept.script, kept.quantity)
    some = [record for record in records if record['event'] in FOLLOWED]
    assert jobs_of(some) == jobs


def test_items_results_and_failures() -> None:
    line = Line(faults={'a2': '#2=abort'}, results={'a2': {'measurement': 2.5}})
    text = with_section(2, '- {id: work, @a2, continue_if_fail: true}')
    run = line.run(text, 2)
    job = jobs_of(run.records)['J']
    good, bad = job.items.values()
    assert good.results['work']['measurement'] == 2.5
    assert 'work' not in bad.results
    assert (good.how, bad.how, bad.nonconforming) == ('packed', 'packed', ['work'])
    (failure,) = job.failures
    assert (failure.item, failure.task, failure.reason) == ('J/2', 'work', 'aborted')
    assert job.counts == Counts(started=2, placed=2, packed=2, nonconforming=1)


def test_priority_times_and_details_stay_with_a_job() -> None:
    line = Line()
    run, script = line.begin(quantity=1), line.script(THREE)
    terms = Terms(7, 1779084000.0, None, {'customer': {'$': ['ACME']}})
    run.ask(AddJobs((Job('K', script, 1, terms=terms), Job('L', script, 1)), BY))
    run.ask(UpdateJob(Job('L', script, 1, terms=replace(terms, due=1779090000.0)), BY))
    run.go(until=2e9)
    jobs = jobs_of(run.records)
    assert [jobs[name].terms for name in 'JKL'] == [
        Terms(),
        terms,
        replace(terms, due=1779090000.0),
    ]
    summary = record_of(run.state.ended['K'])
    assert summary.terms == terms
    assert job_from_plain(json.loads(json_of(job_to_plain(summary)))) == summary


def test_a_job_on_the_line() -> None:
    run = Line().begin(THREE, 2)
    run.go(until=1.5)
    job = jobs_of(run.records)['J']
    assert (job.status, job.ended, job.items['J/1'].how) == ('running', None, '')


def test_summary_stands_for_job_without_beginning() -> None:
    (ended,) = Line().run(THREE, 2).state.ended.values()
    kept = record_of(ended)
    assert job_from_plain(job_to_plain(kept)) == kept
    fold = JobFold([record_of(ended)])
    fold.follow(e.ItemPlaced(job='J', item='J/2', section=1, time=1.0))
    assert fold.jobs['J'] == kept
    fold.follow(e.JobQueued(job='J', script='s', digest='0', quantity=1, time=9.0))
    assert fold.jobs['J'] == JobRecord('J', 's', 1, 9.0, '0')


def test_stopped_job_keeps_status_and_reason() -> None:
    run = Line().begin(THREE, 3)
    run.go(until=1.5)
    run.control('stop', 'J')
    run.go()
    job = jobs_of(run.records)['J']
    assert job.status == 'stopped'
    assert job.reason == run.job().end_reason != ''
    kept = record_of(run.state.ended['J'])
    assert (kept.status, kept.reason) == (job.status, job.reason)


def test_records_of_an_older_and_a_newer_program() -> None:
    order = {'script': 's', 'digest': '0', 'quantity': 2}
    records: list[dict[str, Any]] = [
        {'event': 'job.queued', 'job': 'J', **order, 'time': 1.0},
        {'event': 'job.started', 'job': 'J', 'time': 2.0, 'of a newer program': {'a': 1}},
        {'event': 'job.praised', 'job': 'J', 'time': 2.5},
        {'event': 'task.failed', 'job': 'J', 'task': 'work', 'time': 3.0},
        {'event': 'job.completed', 'job': 'J', 'time': 4.0},
    ]
    (job,) = jobs_of(records).values()
    assert (job.started, job.ended, job.status, job.failures) == (2.0, 4.0, 'completed', [])
