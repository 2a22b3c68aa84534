"""Every surface shows the same numbers of items under the same words (semantics 6.2)."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import replace
from datetime import date
from io import StringIO
from typing import Any, cast

import pytest
from fakes.drawn.lines import lines
from fakes.drawn.plan import Plan
from fakes.line import Line
from fakes.naive_account import is_good
from fakes.plan_operator import operate
from fakes.plan_runs import ProductBench
from fakes.profiles import examples
from fakes.virtual_run import VirtualRun
from hypothesis import given

from bt_orchestrator.engine.runtime.overview import Overview
from bt_orchestrator.extensions.opcua.mes import packml
from bt_orchestrator.extensions.opcua.mes.followed_jobs import FollowedJobs
from bt_orchestrator.extensions.opcua.server.job_control.records import item_plain
from bt_orchestrator.extensions.opcua.server.simple import values as simple_values
from bt_orchestrator.extensions.page.web.account.endpoints import metrics
from bt_orchestrator.extensions.page.web.parts.parts import NOT_KNOWN, job_part
from bt_orchestrator.model.codec import from_record, to_plain
from bt_orchestrator.model.jobs.job_record import JobRecord, all_counts, record_of
from bt_orchestrator.model.keeping.records import Extent
from bt_orchestrator.model.status import CellStatus, ListedJob
from bt_orchestrator.view.report.account.account import Account, Source
from bt_orchestrator.view.report.account.calendar import Now, Turn
from bt_orchestrator.view.report.account.figures import Figures, Paces, figures
from bt_orchestrator.view.report.account.fold import FOLLOWED, AccountFold, FromBooks
from bt_orchestrator.view.report.account.live import Live
from bt_orchestrator.view.report.account.period import Period
from bt_orchestrator.view.report.account.plain import write_csv
from bt_orchestrator.view.report.account.planned import Planned, us_of
from bt_orchestrator.view.report.csv_export import write_items
from bt_orchestrator.view.report.ended_jobs import JobFold
from bt_orchestrator.view.report.isa95.job_response import (
    JobResponse,
    response_of,
    response_of_record,
)

pytestmark = pytest.mark.timeout(24 * 3600)

Numbers = Mapping[str, Any]

WORDS = ('produced', 'good', 'nonconforming', 'rejected')
QUANTITIES = {
    'ProducedQuantity': 'produced',
    'PackedQuantity': 'packed',
    'GoodQuantity': 'good',
    'NonconformingQuantity': 'nonconforming',
    'ScrapQuantity': 'rejected',
}

SIMPLE = {
    'Packed': 'packed',
    'Good': 'good',
    'Rejected': 'rejected',
    'Nonconforming': 'nonconforming',
}
"""Nodes of a job in the flat part of OPC UA."""

_ID = re.compile('(Current|Next|Last)Job/ID').fullmatch

ALL = ''
"""Numbers of all jobs together."""

_ITEMS = re.compile(r'_shift_items{.*outcome="(\w+)"} (\d+)').findall

MARKED = """
sections:
  1: [{id: place, @a1, qty_change: 1, on_failure: continue}]
  2: [{id: work, @a2, on_failure: continue}]
  3: [{id: test, @a3, on_failure: reject}]
  4:
    - parallel:
      - {id: pack, @a4, qty_change: -1, runs_for: all}
      - {id: look, @b4, on_failure: continue}
"""
"""Items are marked, and then packed, rejected or taken off; some are marked when they are gone."""


def told(run: VirtualRun) -> Iterator[tuple[str, str, Numbers]]:
    """Yield what each surface says of each job: name of the surface, job, numbers by word."""
    state, events = run.state, [from_record(entry) for entry in run.records]
    status = Overview(run.sim.orchestrator).status(run.now)
    fold, followed, counter = JobFold(), FollowedJobs(), packml.Counter()
    account = AccountFold(
        Planned.of([(us_of(events[0].time) - 1, us_of(run.now) + 1)]), is_whole=True
    )
    for event in events:
        fold.follow(event)
        followed.follow(event)
        if event.event in FOLLOWED:
            account.follow(event)
    shown = figures(account.until(us_of(run.now) + 1), Paces(run.sim.state.cell))
    yield 'metrics', ALL, in_metrics(shown)
    yield from (('CSV of a report', *entry) for entry in in_csv(shown))
    for made in shown.times.made:
        yield 'report', made.job, {word: getattr(made, word) for word in WORDS}
    for job in status.jobs:
        yield 'status', job.id, {**to_plain(job, whole=True), 'produced': job.produced}
        yield 'response', job.id, quantities(response_of(ListedJob(job)))
        if (booked := followed.get(job.id)) is not None:
            yield 'response by events', job.id, quantities(response_of(booked))
        alone = _only(status, job.id)
        yield 'OPC UA, Simple', job.id, simple(alone, job.id)
        part = job_part(job, status, None, cast('Any', None), NOT_KNOWN)
        yield 'page', job.id, {word: part[word] for word in SIMPLE.values()}
        counter.show(alone)
        (count,) = counter.counts
        yield (
            'PackML',
            job.id,
            {
                'produced': count.processed,
                'good': count.processed - count.defective,
            },
        )
    for record in fold.jobs.values():
        yield 'history', record.job, all_counts(record.counts)
        yield 'items', record.job, by_item(map(item_plain, record.items.values()))
        yield 'CSV of items', record.job, in_items_csv(record)
        if (response := response_of_record(record)) is not None:
            yield 'response by the journal', record.job, quantities(response)
    for ended in state.ended.values():
        yield 'summary', ended.job.id, all_counts(record_of(ended).counts)


def account_of(shown: Figures) -> Account:
    period = Period.all_planned('shift early', 0, 1)
    source = Source(Extent('a', 1, 1), 1, 1, 0)
    return Account(period, shown, source, FromBooks(), has_cell=True, cell_differs=False)


def in_csv(shown: Figures) -> Iterator[tuple[str, Numbers]]:
    file = StringIO()
    write_csv(account_of(shown), file)
    rows = [row for row in csv.DictReader(StringIO(file.getvalue())) if row['part'] == 'job']
    for job in dict.fromkeys(row['name'] for row in rows):
        yield job, {row['detail']: int(row['number']) for row in rows if row['name'] == job}


def in_metrics(shown: Figures) -> Numbers:
    account = account_of(shown)
    turn = Turn('early', date(1970, 1, 1), account.period)
    text = metrics('/n', 0.0, None, Live(Now(account.period, turn), account, None))
    return {kind: int(number) for kind, number in _ITEMS(text)}


def in_items_csv(record: JobRecord) -> Numbers:
    file = StringIO()
    write_items(record, file)
    rows = list(csv.DictReader(StringIO(file.getvalue())))
    packed = [row for row in rows if row['how'] == 'packed']
    rejected = sum(row['how'] == 'rejected' for row in rows)
    return {'packed': len(packed), 'rejected': rejected}


def _only(status: CellStatus, job: str) -> CellStatus:
    jobs = tuple(
        replace(entry, position=min(entry.position, 1)) for entry in status.jobs if entry.id == job
    )
    return replace(status, jobs=jobs)


def simple(status: CellStatus, job: str) -> Numbers:
    """Return what the nodes of the job say, in place of the current, next or last one."""
    shown = dict(simple_values(status))
    (place,) = (path[: -len('ID')] for path, value in shown.items() if value == job and _ID(path))
    return {word: shown[place + name] for name, word in SIMPLE.items()}


def by_item(items: Iterator[dict[str, Any]]) -> Numbers:
    """Count what `GetItems` and the page say of each item."""
    rows = list(items)
    return {
        'good': sum(item['good'] is True for item in rows),
        'packed': sum(item['how'] == 'packed' for item in rows),
        'rejected': sum(item['how'] == 'rejected' for item in rows),
        'produced': sum(item['good'] is not None for item in rows),
        'nonconforming': sum(item['how'] == 'packed' and not item['good'] for item in rows),
    }


def quantities(response: JobResponse) -> Numbers:
    data = {parameter.id: parameter.value for parameter in response.data}
    assert all(type(data[name]) is int for name in QUANTITIES)
    return {word: data[name] for name, word in QUANTITIES.items()}


def agree(run: VirtualRun) -> Counter[str]:
    """Assert that all surfaces say what the records say; returns it."""
    records, truth = run.records, dict[str, Counter[str]]()
    for record in records:
        if record['event'] == 'item.removed':
            kind = 'good' if is_good(record, records) else 'nonconforming'
            word = kind if record['how'] == 'packed' else record['how']
            words = (word, 'produced', *(['packed'] if record['how'] == 'packed' else []))
            truth.setdefault(record['job'], Counter()).update(words)
    for surface, job, numbers in told(run):
        everything = sum(truth.values(), Counter[str]())
        expected = everything if job == ALL else truth.get(job, Counter())
        for word in (*WORDS, 'packed'):
            if word in numbers:
                assert numbers[word] == expected[word], (surface, job, word)
    return sum(truth.values(), Counter[str]())


@pytest.mark.parametrize('until', [9.0, 14.0, 1e6])
def test_items_are_marked_before_and_after_they_leave(until: float) -> None:
    faults = {
        'a1': '#2=abort',
        'a2': '#1=abort #2=abort #3=abort',
        'a3': '#2=abort',
        'b4': '#4=abort',
    }
    line = Line(4, faults=faults)
    run = line.begin(MARKED, 7).go(until=8.0)
    assert run.remove('J/3').accepted
    run.go(until=until)
    counted = agree(run)
    if run.ended:
        marked = {*run.order('item.nonconforming', 'item'), *run.order('task.continued', 'item')}
        assert len(marked) > counted['nonconforming'] > 0
        assert (counted['by_hand'], counted['rejected']) == (1, 1)


@examples(6, 300)
@given(lines())
def test_drawn_lines(plan: Plan) -> None:
    bench = ProductBench(plan)
    operate(bench, plan.moments)
    if bench.run.records:
        agree(bench.run)
