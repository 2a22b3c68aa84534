"""Where the round of a repeat is told: story of an item, record of a job, status, exports."""

from __future__ import annotations

import io
import json

import pytest
from fakes.line import Line, with_section
from fakes.virtual_run import VirtualRun

from bt_orchestrator.model.codec import from_record
from bt_orchestrator.view.report.ended_jobs import JobFold, job_text
from bt_orchestrator.view.report.item.fold import ItemFold
from bt_orchestrator.view.report.xes_export import XesExport

REPEAT = with_section(
    2,
    """
    - repeat:
        - {id: glue, @b2}
        - id: weigh
          task: TASK_A
          action: /a2/do
          fails_unless: {value: "${results.weigh.measurement}", at_least: 1.0}
      times: 2
    """,
)


@pytest.fixture
def run() -> VirtualRun:
    """The first item has two further rounds, the second one has none."""
    return (
        Line(faults={'a2': '#1=reads:0 #2=reads:0.5 #3=reads:1.5 #4=reads:2'})
        .begin(REPEAT, 2)
        .go()
    )


def test_item_history_has_round_of_each_attempt(run: VirtualRun) -> None:
    fold = ItemFold('J/1', 'J')
    for record in run.records:
        fold.follow(from_record(record))
    rounds = [(row.task, row.round, row.outcome) for row in fold.history.tasks if row.section == 2]
    assert rounds == [
        ('glue', 0, 'succeeded'),
        ('weigh', 0, 'failed'),
        ('glue', 1, 'succeeded'),
        ('weigh', 1, 'failed'),
        ('glue', 2, 'succeeded'),
        ('weigh', 2, 'succeeded'),
    ]


def test_job_record_has_rounds_of_each_item(run: VirtualRun) -> None:
    fold = JobFold()
    for record in run.records:
        fold.follow(from_record(record))
    first, second = fold.jobs['J'].items.values()
    assert (first.rounds, second.rounds) == ({'glue': 2}, {})
    assert first.results['weigh']['measurement'] == 1.5
    lines = list(job_text(list(fold.jobs.values()), with_items=True))
    assert lines.count('    glue: 2 more rounds') == 1


def test_the_status_has_the_round_of_what_runs() -> None:
    run = Line(faults={'a2': '#1=reads:0'}).begin(REPEAT, 1).go(until=5.5)
    ((running,),) = [section.running for section in run.sim.status().sections if section.running]
    assert (running.id, running.round, running.attempt) == ('glue', 1, 1)


def test_an_export_for_process_mining_has_the_round(run: VirtualRun) -> None:
    file = io.StringIO()
    export = XesExport(file)
    for record in run.records:
        export.write(json.dumps(record))
    export.close()
    assert file.getvalue().count('<int key="round" value="2"/>') == 2


def test_refused_results_are_shown_with_item(run: VirtualRun) -> None:
    fold = JobFold()
    for record in run.records:
        fold.follow(from_record(record))
    lines = list(job_text(list(fold.jobs.values()), with_items=True))
    expected = 'expected ${results.weigh.measurement} at least 1.0'
    refused = [line for line in lines if line.startswith('    weigh failed')]
    assert refused == [
        f'    weigh failed: result_refused ({expected}; found {reading})' for reading in (0.0, 0.5)
    ]
