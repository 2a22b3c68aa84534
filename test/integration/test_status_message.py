"""The status of a line at each point of a virtual run, as the message that watchers get."""

from __future__ import annotations

import argparse
import json
from datetime import datetime
from pathlib import Path
from typing import Any

import pytest
from bt_orchestrator_interfaces.srv import QueueList
from fakes.dot_text import DotText
from fakes.line import THREE, Line
from fakes.virtual_run import BY, VirtualRun

from bt_orchestrator.cli.order_terms import add_term_options, changed_terms
from bt_orchestrator.cli.queue import others
from bt_orchestrator.drawing.status_marks import line_state
from bt_orchestrator.model.jobs.job_commands import AddJobs, UpdateJob
from bt_orchestrator.model.jobs.order import Job, Terms
from bt_orchestrator.model.snapshot import state_from_plain, state_to_plain
from bt_orchestrator.report.pace import expected_ends_s
from bt_orchestrator.ros.services.expected_ends import nearest
from bt_orchestrator.ros.services.job_message import list_queue
from bt_orchestrator.ros.services.status_message import status_message
from bt_orchestrator.ros.stamps import to_time
from bt_orchestrator.ros.types.messages import to_plain
from bt_orchestrator.screen import words
from bt_orchestrator.screen.advice import Shell
from bt_orchestrator.screen.view import cell_view
from bt_orchestrator.tree.draw import draw

SCRIPT = """
params: {off: {type: bool, default: true}}
initialization: [{id: home, task: PREPARE, action: /b2/do}]
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2:
    - {id: look, @a2, %s}
    - {id: next, @a2.TASK_B}
    - {id: photo, @b2, runs_for: all}
  3: [{id: pack, @a3, qty_change: -1, runs_for: all}]
"""


def at_work(line: Line, options: str, answer: str = '') -> VirtualRun:
    """Run until section 2 takes the photo of its first item, or the line is held."""
    run = line.begin(SCRIPT % options, quantity=3).go(until=5.0)
    if answer:
        run.answer(answer)
        run.go(until=5.5)
    return run


def status(run: VirtualRun) -> Any:
    return status_message(run.sim.orchestrator, run.now, {})


def passed(message: Any) -> dict[str, tuple[str, str]]:
    return {one.id: (one.end, one.reason) for one in message.sections[1].passed}


@pytest.mark.parametrize(
    ('options', 'answer', 'look', 'word'),
    [
        ('on_failure: reject', '', ('rejected', 'task_result_false'), 'failed, item rejected'),
        ('on_failure: continue', '', ('continued', 'task_result_false'), 'failed, continued'),
        ('on_failure: abort_job', '', ('aborted', 'task_result_false'), 'failed, job aborted'),
        ('on_failure: hold', 'reject', ('rejected', 'task_result_false'), 'failed, item rejected'),
        ('on_failure: hold', 'mark_done', ('marked_done', 'task_result_false'), 'marked done'),
        ('on_failure: hold', 'skip', ('skipped', 'Ann decided skip: it looked so'), 'skipped'),
        ('unless: "${params.off}"', '', ('skipped', 'unless ${params.off}'), 'skipped'),
        ('retries: 1', '', ('done', ''), 'done'),
    ],
)
def test_a_task_that_was_passed_says_how_it_ended(
    options: str, answer: str, look: tuple[str, str], word: str
) -> None:
    line = Line(faults={'a2': 'TASK_A#1=false'}, seconds={'b2': 3.0})
    run = at_work(line, options, answer)
    if 'retries' in options:
        run.go(until=6.5)
    message = status(run)
    found = passed(message)
    assert found['look'][0] == look[0]
    assert found['look'][1].startswith(look[1])
    assert message.sections[1].done == list(found)
    assert ('look' in message.sections[1].failed) is (
        look[0] in ('rejected', 'continued', 'aborted')
    )

    state = line_state(json.loads(json.dumps(to_plain(message))), run.state.script('J'), line.cell)
    picture = DotText(draw(run.state.script('J'), line.cell, state=state).dot)
    assert picture.words('task.look')[0].endswith(word)


def test_a_rejected_item_is_told_wherever_it_stands() -> None:
    line = Line(faults={'a2': 'TASK_A#1=false'}, seconds={'b2': 3.0})
    run = at_work(line, 'on_failure: reject')
    section = status(run).sections[1]
    assert (section.slot_rejected, section.item_rejected) == (True, True)
    assert passed(status(run))['next'] == ('skipped', 'rejected item')
    assert words.fate(section) == 'rejected'

    run.go(until=9.5)
    message = status(run)
    assert [one.slot for one in message.sections] == ['', 'J/2', 'J/1']
    assert [one.slot_rejected for one in message.sections] == [False, False, True]


def test_a_nonconforming_item_names_the_tasks() -> None:
    run = at_work(
        Line(faults={'a2': 'TASK_A#1=false'}, seconds={'b2': 3.0}), 'on_failure: continue'
    )
    section = status(run).sections[1]
    assert (section.slot_nonconforming, section.item_nonconforming) == (['look'], ['look'])


def test_an_empty_position_is_told_of_the_cycle_too() -> None:
    line = Line(seconds={'b2': 3.0})
    run = at_work(line, 'timeout: none')
    run.remove('J/1')
    section = status(run).sections[1]
    assert (section.slot_empty_position, section.item_empty_position) == (True, True)


def test_initialization_that_ended_is_told() -> None:
    run = at_work(Line(faults={'b2': 'PREPARE=false'}), 'timeout: none')
    run.answer('mark_done')
    (job,) = status(run).jobs
    assert [(one.id, one.end) for one in job.passed] == [('home', 'marked_done')]


# --- a long queue ---------------------------------------------------------------------------


def long_queue(number: int) -> VirtualRun:
    """Return a line that works on J, with many jobs behind it."""
    line = Line()
    run = line.begin(quantity=2).go(until=1.5)
    script = line.script(THREE)
    assert run.add(*((f'Q-{n}', script) for n in range(1, number + 1))).accepted
    return run


def test_a_status_lists_the_first_jobs_of_a_long_queue_and_counts_them() -> None:
    message, short = status(long_queue(250)), status(long_queue(3))
    assert [job.id for job in message.jobs] == ['J', *(f'Q-{n}' for n in range(1, 101))]
    assert [job.position for job in message.jobs] == list(range(101))
    assert message.queued == 250
    more = '  150 more jobs in the queue: bt-orchestrator queue'
    assert more in words.status_lines(message, Shell())
    assert cell_view(message, Shell()).unlisted_jobs == 150
    assert not any('more jobs' in line for line in words.status_lines(short, Shell()))


class Asked:
    """A node that is asked for its queue, and loses jobs from it meanwhile."""

    def __init__(self, run: VirtualRun, *cancelled: str) -> None:
        self.run = run
        self._cancelled = list(cancelled)
        self.asked = 0

    def call(self, kind: Any, service: str, request: Any) -> Any:
        assert (kind, service) == (QueueList, 'queue/list')
        response = QueueList.Response()
        if self._cancelled:
            assert self.run.control('cancel', self._cancelled.pop(0)).accepted
        list_queue(self.run.state, request, response)
        self.asked += 1
        return response


@pytest.mark.parametrize('cancelled', [(), ('Q-7',), ('Q-100', 'Q-600'), ('Q-100', 'Q-500')])
def test_the_others_are_asked_for_page_by_page(cancelled: tuple[str, ...]) -> None:
    run = long_queue(1300)
    message = status(run)
    node = Asked(run, *cancelled)
    found = [job.id for job in (*message.jobs, *others(node, message))]
    assert sorted(set(found), key=found.index) == found
    assert {'J', *(job.job.id for job in run.state.queue)} <= set(found)
    assert node.asked <= 7


def test_of_a_short_queue_nobody_asks_for_more() -> None:
    run = long_queue(100)
    node = Asked(run)
    assert others(node, status(run)) == []
    assert node.asked == 0


def test_a_page_begins_behind_a_job_and_has_an_end() -> None:
    run = long_queue(20)
    response = QueueList.Response()
    list_queue(run.state, QueueList.Request(after='Q-5', most=3), response)
    assert [job.id for job in response.jobs] == ['Q-6', 'Q-7', 'Q-8']
    assert (response.accepted, response.queued) == (True, 20)
    response = QueueList.Response()
    list_queue(run.state, QueueList.Request(after='J'), response)
    assert (response.accepted, response.message) == (False, 'J is not in the queue')


def test_a_job_tells_its_priority_and_times_and_the_queue_its_details() -> None:
    line = Line()
    run, script = line.begin(quantity=2).go(until=1.5), line.script(THREE)
    terms = Terms(7, 1779084000.0, 1779090000.5, {'customer': 'ACME'})
    jobs = (Job('A', script, 1, terms=terms), Job('B', script, 1))
    assert run.ask(AddJobs(jobs, BY)).accepted
    message = status(run)
    a, b = message.jobs[1:]
    assert (a.priority, a.start.sec, a.due.sec, a.due.nanosec) == (
        *(7, 1779084000),
        *(1779090000, 500_000_000),
    )
    assert (b.priority, b.start.sec, b.due.sec) == (0, 0, 0)
    assert 'ACME' not in str(message)
    times = [datetime.fromtimestamp(time) for time in (terms.start, terms.due) if time]
    told = ', priority 7, start {:%Y-%m-%d %H:%M}, due {:%Y-%m-%d %H:%M}'.format(*times)
    assert [words.job_terms(job) for job in (a, b)] == [told, '']
    assert any(told in text for text in words.status_lines(message, Shell()))

    response = QueueList.Response()
    list_queue(run.state, QueueList.Request(), response)
    assert [json.loads(text or '{}') for text in response.details] == [terms.details, {}]


def test_a_job_tells_the_digest_of_its_script_queued_on_the_line_and_ended() -> None:
    line = Line()
    run = line.begin(quantity=2).go(until=1.5)
    other = line.script(THREE.replace('id: pack', 'id: out'), 'other')
    run.submit('A', other)
    digests = {record['script']: record['digest'] for record in run.all('script.loaded')}
    expected = [('J', digests['test']), ('A', digests['other'])]
    assert [(job.id, job.digest) for job in status(run).jobs] == expected
    run.ask(UpdateJob(Job('A', run.state.script('J'), 1), BY))
    assert status(run).jobs[1].digest == digests['test']
    run.go()
    assert [job.digest for job in status(run).jobs] == [digests['test']] * 2


def test_a_page_of_the_queue_is_shorter_where_details_are_long() -> None:
    line = Line()
    run, script = line.begin(quantity=2).go(until=1.5), line.script(THREE)
    terms = Terms(details={'a': 'x' * 7_900})
    jobs = tuple(Job(f'Q-{n}', script, 1, terms=terms) for n in range(200))
    assert run.ask(AddJobs(jobs, BY)).accepted
    seen: list[str] = []
    for _ in range(2):
        response = QueueList.Response()
        list_queue(run.state, QueueList.Request(after=seen[-1] if seen else ''), response)
        assert len(response.jobs) == len(response.details)
        assert 50 < len(response.jobs) < 150
        seen += [job.id for job in response.jobs]
    assert seen == [job.id for job in jobs]


def test_what_is_changed_of_priority_times_and_details(tmp_path: Path) -> None:
    (tmp_path / 'details.json').write_text('{"lot": 7}')
    parser = argparse.ArgumentParser()
    add_term_options(parser)

    def changed(*words: str) -> dict[str, Any]:
        return changed_terms(parser.parse_args(words))

    assert changed() == {}
    assert changed('--priority', '-5', '--details', ' {"a": 1}') == {
        'priority': [-5],
        'details': '{"a": 1}',
    }
    assert changed('--details', str(tmp_path / 'details.json')) == {'details': '{"lot": 7}'}
    assert changed('--details', 'none', '--start', 'none', '--due', '2026-05-18T06:00Z') == {
        'details': '{}',
        'start': [to_time(0.0)],
        'due': [to_time(1779084000.0)],
    }


def test_a_forecast_is_asked_about_the_first_jobs() -> None:
    run = long_queue(250)
    near = state_from_plain(run.state.cell, state_to_plain(nearest(run.state)))
    assert list(near.jobs) == ['J', *(f'Q-{n}' for n in range(1, 101))]
    assert near.scripts == run.state.scripts
    assert list(expected_ends_s(run.state, run.state.cell)) == list(near.jobs)
