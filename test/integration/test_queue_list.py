"""A long queue: what a status lists of it, and the pages in which the rest is asked for."""

from __future__ import annotations

import argparse
import json
from datetime import datetime
from pathlib import Path
from typing import Any

import pytest
from bt_orchestrator_interfaces.srv import ListJobs, QueueList
from fakes.line import THREE, Line
from fakes.virtual_run import BY, VirtualRun

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.cli.asked.derived import given, of_request
from bt_orchestrator.cli.queue import others
from bt_orchestrator.engine.runtime.overview import Overview
from bt_orchestrator.model.jobs.job_commands import AddJobs, UpdateJob
from bt_orchestrator.model.jobs.order import Job, Terms
from bt_orchestrator.model.keeping.snapshot import nearest, state_from_plain, state_to_plain
from bt_orchestrator.model.requests import UPDATE
from bt_orchestrator.ports import QueuePage
from bt_orchestrator.ros.services.reading_services import list_jobs, list_queue
from bt_orchestrator.ros.types.status_messages import job_message, job_status, listed_job
from bt_orchestrator.view.report.pace import expected_ends_s
from bt_orchestrator.view.screen import words
from bt_orchestrator.view.screen.advice import Shell
from bt_orchestrator.view.screen.view import cell_view


def long_queue(number: int) -> VirtualRun:
    """Return a line that works on J, with many jobs behind it."""
    line = Line()
    run = line.begin(quantity=2).go(until=1.5)
    script = line.script(THREE)
    assert run.add(*((f'Q-{n}', script) for n in range(1, number + 1))).accepted
    return run


def test_status_lists_first_jobs_and_counts_long_queue() -> None:
    message, short = long_queue(250).sim.status(), long_queue(3).sim.status()
    assert [job.id for job in message.jobs] == ['J', *(f'Q-{n}' for n in range(1, 101))]
    assert [job.position for job in message.jobs] == list(range(101))
    assert message.queued == 250
    more = '  150 more jobs in the queue: bt-orchestrator queue'
    assert more in words.status_lines(message, Shell())
    assert cell_view(message, Shell()).unlisted_jobs == 150
    assert not any('more jobs' in line for line in words.status_lines(short, Shell()))


def list_page(run: VirtualRun, request: Any) -> Any:
    """Return what the node answers."""
    response = QueueList.Response()
    list_queue(run.state, Overview(run.sim.orchestrator), request, response)
    return response


class Asked:
    """A node that is asked for its queue, and loses jobs from it meanwhile."""

    def __init__(self, run: VirtualRun, *cancelled: str) -> None:
        self.run = run
        self._cancelled = list(cancelled)
        self.asked = 0

    def queue(self, after: str = '', most: int = 0) -> QueuePage:
        if self._cancelled:
            assert self.run.control('cancel', self._cancelled.pop(0)).accepted
        self.asked += 1
        response = list_page(self.run, QueueList.Request(after=after, most=most))
        if not response.accepted:
            raise CommandRefused(response.message)
        return QueuePage(tuple(map(job_status, response.jobs)), response.queued)


@pytest.mark.parametrize('cancelled', [(), ('Q-7',), ('Q-100', 'Q-600'), ('Q-100', 'Q-500')])
def test_the_others_are_asked_for_page_by_page(cancelled: tuple[str, ...]) -> None:
    run = long_queue(1300)
    message = run.sim.status()
    node = Asked(run, *cancelled)
    ids = [job.id for job in (*message.jobs, *others(node, message))]
    assert sorted(set(ids), key=ids.index) == ids
    assert {'J', *(job.job.id for job in run.state.queue)} <= set(ids)
    assert node.asked <= 7


def test_of_a_short_queue_nobody_asks_for_more() -> None:
    run = long_queue(100)
    node = Asked(run)
    assert others(node, run.sim.status()) == []
    assert node.asked == 0


def test_page_starts_after_job_and_is_limited() -> None:
    run = long_queue(20)
    response = list_page(run, QueueList.Request(after='Q-5', most=3))
    assert [job.id for job in response.jobs] == ['Q-6', 'Q-7', 'Q-8']
    assert (response.accepted, response.queued) == (True, 20)
    response = list_page(run, QueueList.Request(after='J'))
    assert (response.accepted, response.message) == (False, 'J is not in the queue')


def test_status_tells_priority_and_times_queue_tells_details() -> None:
    line = Line()
    run, script = line.begin(quantity=2).go(until=1.5), line.script(THREE)
    terms = Terms(7, 1779084000.0, 1779090000.5, {'customer': 'ACME'})
    jobs = (Job('A', script, 1, terms=terms), Job('B', script, 1))
    assert run.ask(AddJobs(jobs, BY)).accepted
    status = run.sim.status()
    a, b = status.jobs[1:]
    assert (a.priority, a.start, a.due) == (7, terms.start, terms.due)
    assert (b.priority, b.start, b.due) == (0, None, None)
    assert 'ACME' not in str(status)
    times = [datetime.fromtimestamp(time) for time in (terms.start, terms.due) if time]
    phrase = ', priority 7, waits for its start {:%Y-%m-%d %H:%M}, due {:%Y-%m-%d %H:%M}'.format(
        *times
    )
    assert [words.job_terms(job) for job in (a, b)] == [phrase, '']
    assert any(phrase in text for text in words.status_lines(status, Shell()))

    response = list_page(run, QueueList.Request())
    assert [json.loads(text or '{}') for text in response.details] == [terms.details, {}]


def test_job_shows_script_digest_in_every_state() -> None:
    line = Line()
    run = line.begin(quantity=2).go(until=1.5)
    other = line.script(THREE.replace('id: pack', 'id: out'), 'other')
    run.submit('A', other)
    digests = {record['script']: record['digest'] for record in run.all('script.loaded')}
    expected = [('J', digests['test']), ('A', digests['other'])]
    assert [(job.id, job.digest) for job in run.sim.status().jobs] == expected
    run.ask(UpdateJob(Job('A', run.state.script('J'), 1), BY))
    assert run.sim.status().jobs[1].digest == digests['test']
    run.go()
    assert [job.digest for job in run.sim.status().jobs] == [digests['test']] * 2


def test_job_tells_queue_start_and_end_times() -> None:
    line = Line()
    run = line.begin(quantity=2).go(until=1.5)
    run.submit('A', line.script(THREE))
    (queued,) = run.all('job.queued', job='A')
    seen = job_status(job_message(run.sim.status().jobs[1]))
    assert (seen.queued_at, seen.started_at, seen.ended_at) == (queued['time'], None, None)
    run.go()
    for job in run.sim.status().jobs:
        (started,) = run.all('job.started', job=job.id)
        (ended,) = run.all('job.completed', job=job.id)
        seen = job_status(job_message(job))
        assert (seen.started_at or 0.0, seen.ended_at) == (started['time'], ended['time'])
        assert 0.0 <= seen.queued_at <= started['time'] < ended['time']


def test_job_page_shrinks_with_long_params_and_details() -> None:
    line = Line()
    run, script = line.begin(quantity=2).go(until=1.5), line.script(THREE)
    terms = Terms(details={'a': 'x' * 7_000})
    jobs = tuple(Job(f'Q-{n}', script, 1, {'b': 'x' * 900}, terms) for n in range(200))
    assert run.ask(AddJobs(jobs, BY)).accepted
    names: list[str] = []
    for _ in range(2):
        request, response = ListJobs.Request(after=names[-1] if names else ''), ListJobs.Response()
        list_jobs(run.state, Overview(run.sim.orchestrator), request, response)
        page = list(map(listed_job, response.jobs))
        assert 1 <= len(page) < 150
        assert all(entry.details == terms.details for entry in page if entry.status.id != 'J')
        names += [entry.status.id for entry in page]
    assert names == ['J', *(job.id for job in jobs)]


def test_queue_page_shrinks_with_long_details() -> None:
    line = Line()
    run, script = line.begin(quantity=2).go(until=1.5), line.script(THREE)
    terms = Terms(details={'a': 'x' * 7_900})
    jobs = tuple(Job(f'Q-{n}', script, 1, terms=terms) for n in range(200))
    assert run.ask(AddJobs(jobs, BY)).accepted
    seen: list[str] = []
    for _ in range(2):
        response = list_page(run, QueueList.Request(after=seen[-1] if seen else ''))
        assert len(response.jobs) == len(response.details)
        assert 50 < len(response.jobs) < 150
        seen += [job.id for job in response.jobs]
    assert seen == [job.id for job in jobs]


def test_what_is_changed_of_priority_times_and_details(tmp_path: Path) -> None:
    (tmp_path / 'details.json').write_text('{"lot": 7}')
    parser = argparse.ArgumentParser()
    of_request(UPDATE).add_arguments(parser)

    def changed(*words: str) -> dict[str, Any]:
        typed = given(UPDATE, parser.parse_args(['J', *words, '--reason', 'why']))
        assert typed.pop('job') == 'J'
        return typed

    assert changed() == {}
    assert changed('--priority', '-5', '--details', ' {"a": 1}') == {
        'priority': -5,
        'details': {'a': 1},
    }
    assert changed('--details', str(tmp_path / 'details.json')) == {'details': {'lot': 7}}
    update = changed('--details', 'none', '--start', 'none', '--due', '2026-05-18T06:00Z')
    assert update == {'details': {}, 'start': 'none', 'due': '2026-05-18T06:00Z'}


def test_a_forecast_is_asked_about_the_first_jobs() -> None:
    run = long_queue(250)
    near = state_from_plain(run.state.cell, state_to_plain(nearest(run.state)))
    assert list(near.jobs) == ['J', *(f'Q-{n}' for n in range(1, 101))]
    assert near.scripts == run.state.scripts
    assert list(expected_ends_s(run.state, run.state.cell)) == list(near.jobs)
