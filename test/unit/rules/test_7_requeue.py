"""Semantics 7.6: a job by recipe is stopped, and what it has not begun is queued anew."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fakes.action_types import FakeActionTypes
from fakes.commands import Reset, Start, Stop
from fakes.operator import ann
from fakes.recipe_bench import BOX, Bench
from fakes.script_texts import LINE, cell, script
from fakes.virtual_run import VirtualRun

from bt_orchestrator.base.errors import Finding, NotRead, Refused
from bt_orchestrator.base.replies import Reply, begin
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.jobs.job_commands import RequeueJob
from bt_orchestrator.model.jobs.order import Job, MadeAnew, Terms, WorkOrder
from bt_orchestrator.model.requests import ask
from bt_orchestrator.model.state import JobState
from bt_orchestrator.ports import MadeScript

ORIGIN = 'made_from: {recipe: BOX-7, version: 1, recipe_digest: aa11}\n'
LOTS = 'params: {glue: {type: str, default: none}}\nlots: {glue: "${params.glue}"}\n'


def at(component: str, more: str = '', says: str = 'aa11') -> MadeScript:
    """Return the script in which a component glues."""
    glue = f'  3: [{{id: glue, task: TASK_A, action: /{component}/task}}]\n'
    line = LINE.replace('qty_change: -1', 'qty_change: -1, runs_for: all')
    return MadeScript('BOX-7', f'{line}{glue}{LOTS}{more}{ORIGIN.replace("aa11", says)}')


NOT_MADE = Refused([Finding('recipe BOX-7', 1, 1, 'glue: only press could')])


class Node:
    """A line at work, whose scripts are generated when the test says so."""

    def __init__(self, folder: Path) -> None:
        self.run = VirtualRun(cell(), FakeActionTypes())
        self.bench = Bench(folder, self.run.sim)

    def order(self, name: str, quantity: int, terms: Terms | None = None) -> None:
        """Give an order by recipe whose script an engineer has released."""
        params = {'glue': 'G-7'}
        order = WorkOrder('', name, quantity, params, terms or Terms(), BOX)
        given = begin(self.bench.handler.carry_out(ask('queue.add', ann(), orders=[order])))
        self.bench.give(at('press'))
        assert given.value.accepted, given.value.message
        if self.job(name).awaits_release:
            assert self.run.release(script(at('press').text)).accepted

    def requeue(self, name: str, order: str | None = None) -> Reply[Answer]:
        return begin(
            self.bench.handler.carry_out(ask('job.requeue', ann(), job=name, order=order))
        )

    def requeued(self, name: str, made: MadeScript, order: str | None = None) -> str:
        """Requeue a job; return the answer."""
        reply = self.requeue(name, order)
        self.bench.give(made)
        assert reply.value.accepted, reply.value.message
        return reply.value.message

    def refused(self, name: str, order: str | None = None) -> str:
        """Return why a job is not requeued, before anything is generated."""
        asked = len(self.bench.asked)
        answer = self.requeue(name, order).value
        assert not answer.accepted
        assert len(self.bench.asked) == asked, 'no search for nothing'
        (record,) = self.run.records[-1:]
        assert (record['command'], record['message']) == ('requeue', answer.message)
        return answer.message

    def job(self, name: str) -> JobState:
        return self.run.state.jobs[name]

    @property
    def queue(self) -> list[str]:
        return [job.job.id for job in self.run.state.queue]

    def queued(self, name: str) -> dict[str, Any]:
        (queued_job,) = (record for record in self.run.all('job.queued') if record['job'] == name)
        return queued_job


@pytest.fixture
def node(tmp_path: Path) -> Iterator[Node]:
    node = Node(tmp_path)
    yield node
    node.run.sim.close()


TERMS = Terms(priority=3, due=9000.0, details={'customer': 'ACME'})


def test_7_6_requeue_stops_job_and_queues_rest_first(node: Node) -> None:
    node.order('A', 5, TERMS)
    node.order('B', 1)
    node.run.go(until=3.0)
    begun = node.job('A').progress.started
    answer = node.run.service('press', out=True).message
    way = 'A on the line needs press and waits; to make the rest without it now: job requeue A'
    assert way in answer.splitlines()
    before = len(node.run.records)
    message = node.requeued('A', at('table'))
    records = node.run.records[before:]
    assert [record['event'] for record in records[:4]] == [
        'operator.decided',
        'job.stopping',
        'script.loaded',
        'job.queued',
    ]
    assert (records[0]['answer'], records[0]['job']) == ('requeue', 'A')
    assert len({record['time'] for record in records[:4]}) == 1
    assert node.job('A').stopping
    assert node.queue == ['A-rest', 'B']
    rest = node.job('A-rest')
    assert rest.job.quantity == 5 - begun
    assert (rest.job.terms, rest.job.params, rest.job.recipe) == (TERMS, {'glue': 'G-7'}, BOX)
    assert (rest.rest_of, rest.ranked) == ('A', False)
    assert rest.anew == MadeAnew(('press',), (), 2.0, 2.0)
    assert rest.awaits_release, 'an engineer has to see what was generated'
    assert f'A-rest is queued first, with {5 - begun} items, made anew without press: ' in message


def test_7_6_together_they_make_what_was_ordered(node: Node) -> None:
    node.order('A', 5)
    node.run.go(until=4.0)
    node.requeued('A', at('table'))
    assert node.run.release(script(at('table').text)).accepted
    node.run.go()
    first, rest = (node.run.state.ended[name] for name in ('A', 'A-rest'))
    assert (first.exit_status, rest.exit_status) == ('stopped', 'completed')
    assert first.progress.packed + rest.progress.packed == 5
    assert 'Ann decided requeue' in first.end_reason
    glued = [row for row in node.run.all('task.started') if row['task'] == 'glue']
    assert {row['component'] for row in glued if row['job'] == 'A-rest'} == {'table'}
    placed = [row for row in node.run.all('item.placed') if row['item'].startswith('A-rest/')]
    assert placed[0]['item'] == 'A-rest/1', 'its items count from 1'
    assert all(row['lots'] == {'glue': 'G-7'} for row in placed)


def test_7_6_items_that_begin_meanwhile_stay_with_the_job(node: Node) -> None:
    node.order('A', 6)
    node.run.go(until=1.0)
    begun, events = node.job('A').progress.started, len(node.run.records)
    reply = node.requeue('A')
    assert len(node.run.records) == events, 'nothing before the script is there'
    node.run.go(until=6.0)
    assert node.job('A').progress.started > begun
    node.bench.give(at('table'))
    assert reply.value.accepted
    assert node.job('A-rest').job.quantity == 6 - node.job('A').progress.started


def test_7_6_rest_counts_items_not_begun_when_queued(node: Node) -> None:
    node.order('A', 6)
    node.run.go(until=3.0)
    left, order = node.job('A').cycles_left, Job('R', script(at('table').text), 6, recipe=BOX)
    assert node.run.ask(RequeueJob('A', order, ann())).accepted, 'it was read some time ago'
    assert node.job('R').job.quantity == left < 6


def test_7_6_nothing_is_left_when_the_script_is_there(node: Node) -> None:
    node.order('A', 4)
    node.run.go(until=1.0)
    reply = node.requeue('A')
    node.run.go()
    node.bench.give(at('table'))
    assert reply.value.message.startswith('A is Ended; Requeue is for jobs that are Running')
    assert node.queue == []


@pytest.mark.parametrize(
    ('outcome', 'why'),
    [
        (NOT_MADE, 'glue: only press could'),
        (NotRead('generating took too long'), 'generating took too long'),
        (at('table', says='bb22'), 'recipe BOX-7 version 1 was another one before'),
        (at('table', 'params: {}\n'), 'the key `params` is given twice'),
    ],
    ids=['not made', 'not generated', 'another version 1', 'not read'],
)
def test_7_6_one_that_cannot_be_queued_changes_nothing(node: Node, outcome: Any, why: str) -> None:
    node.order('A', 5)
    node.run.go(until=3.0)
    reply, before = node.requeue('A'), len(node.run.records)
    given = node.bench.replies.pop(0)
    given.give(outcome if isinstance(outcome, NotRead) else (outcome,))
    answer = reply.value
    assert not answer.accepted
    assert why in ' '.join([answer.message, *(f for row in answer.orders for f in row.findings)])
    assert [row['event'] for row in node.run.records[before:]] == ['operator.refused']
    assert node.run.records[-1]['job'] == 'A'
    assert not node.job('A').stopping
    assert node.queue == []
    node.run.go()
    assert node.run.state.ended['A'].exit_status == 'completed'


def test_7_6_what_has_no_rest_is_refused_at_once(node: Node) -> None:
    assert node.bench.order('S', recipe=None).value.accepted
    node.order('A', 2)
    assert 'S is NotAllowedToStart; Requeue is for jobs that are Running' in node.refused('S')
    assert node.run.control('release', 'S').accepted
    node.run.go(until=1.0)
    assert node.refused('X').startswith('there is no job X; jobs now: ')
    node.run.go(until=4.0)
    assert node.job('A').cycles_left == 0
    assert node.refused('A') == (
        'A has begun all of its items, so nothing is left to queue; nothing was done'
    )


def test_7_6_job_ordered_by_script_is_refused(node: Node) -> None:
    order = WorkOrder('test', 'S', 4)
    assert begin(
        node.bench.handler.carry_out(ask('queue.add', ann(), orders=[order]))
    ).value.accepted
    node.run.go(until=1.0)
    assert node.refused('S') == (
        'S was ordered by its script, so it cannot be made anew; stop it (job stop S), and give '
        'an order for the rest'
    )


@pytest.mark.parametrize('verb', ['stop', 'abort', 'requeue'])
def test_7_6_a_job_that_ends_already_is_refused(node: Node, verb: str) -> None:
    node.order('A', 5)
    node.run.go(until=3.0)
    if verb == 'requeue':
        node.requeued('A', at('table'))
    else:
        assert node.run.control(verb, 'A').accepted
    ending = 'aborting' if verb == 'abort' else 'stopping'
    assert node.refused('A').startswith(f'A is {ending} already')


def test_7_6_rest_gets_free_id_and_names_origin(node: Node) -> None:
    node.order('A', 20)
    node.order('A-rest', 1)
    node.run.go(until=1.0)
    assert node.refused('A', 'A-rest/2') == (
        "'A-rest/2' cannot be the id of the rest: a slash separates the order from the number of "
        'the item; give another one'
    )
    taken = node.requeue('A', 'A-rest')
    node.bench.give(at('table'))
    assert 'order A-rest was given before; choose another id' in taken.value.message
    node.requeued('A', at('press'))
    assert node.queue == ['A-rest-2', 'A-rest']
    node.run.go(until=12.0)
    assert node.job('A-rest-2').started
    node.requeued('A-rest-2', at('press'))
    assert node.queued('A-rest-3')['rest_of'] == 'A-rest-2'
    node.run.go(until=20.0)
    node.requeued('A-rest-3', at('press'), 'LAST')
    assert node.queued('LAST')['rest_of'] == 'A-rest-3'
    node.run.go()
    names = ('A', 'A-rest-2', 'A-rest-3', 'LAST')
    assert sum(node.run.state.ended[name].progress.packed for name in names) == 20


def test_7_6_overlong_rest_id_must_be_replaced(node: Node) -> None:
    name = 'J' * 62
    node.order(name, 5)
    node.run.go(until=1.0)
    assert 'it has 67 characters, at most 64 are allowed; give another one' in node.refused(name)
    node.requeued(name, at('table'), 'REST')
    assert node.queue == ['REST']


def test_7_6_rest_ignores_start_and_pause_of_job(node: Node) -> None:
    node.order('A', 5, Terms(start=500.0))
    assert node.job('A').awaits_start
    assert node.run.control('release', 'A').accepted
    node.run.go(until=3.0)
    assert node.run.control('pause', 'A').accepted
    node.requeued('A', at('press'))
    rest = node.job('A-rest')
    assert (rest.job.terms.start, rest.awaits_start, rest.held) == (500.0, False, False)
    assert rest.anew is None, 'the same script came of it'
    node.run.go(until=400.0)
    assert node.run.state.ended['A-rest'].exit_status == 'completed'


def test_7_6_job_without_begun_items_is_requeued_whole(node: Node) -> None:
    preparing = 'initialization: [{id: look, task: PREPARE, action: /loader/task}]\n'
    assert node.run.service('press', out=True).accepted
    order = WorkOrder('', 'A', 3, recipe=BOX)
    given = begin(node.bench.handler.carry_out(ask('queue.add', ann(), orders=[order])))
    assert node.run.service('press', out=False).accepted
    node.bench.give(at('press'))
    node.bench.give(at('press', preparing))
    assert given.value.accepted, given.value.message
    assert node.run.release(script(at('press', preparing).text)).accepted
    assert node.job('A').started
    node.requeued('A', at('table'))
    assert node.run.release(script(at('table').text)).accepted
    node.run.go()
    first, rest = (node.run.state.ended[name] for name in ('A', 'A-rest'))
    assert (first.progress.started, first.exit_status) == (0, 'stopped')
    assert rest.progress.packed == 3


def test_7_6_answer_reports_items_waiting_for_lost_component(node: Node) -> None:
    node.order('A', 6)
    node.run.go(until=2.0)
    assert node.run.service('press', out=True).accepted
    message = node.requeued('A', at('table'))
    assert (
        'its items on the line still need press and wait; in-service lets it go on, or an '
        'engineer takes its items off (remove-item) or aborts it (job abort A)'
    ) in message
    assert node.run.release(script(at('table').text)).accepted
    node.run.go()
    assert node.job('A').ending == 'stopping'
    assert node.run.control('abort', 'A').accepted
    node.run.go()
    assert node.run.state.ended['A-rest'].progress.packed == node.queued('A-rest')['quantity']


def test_7_6_rest_lacking_component_is_passed(node: Node) -> None:
    node.order('A', 5)
    node.order('B', 1)
    node.run.go(until=3.0)
    conveyor = cell().conveyor.component.name
    assert node.run.service(conveyor, out=True).accepted
    message = node.requeued('A', at('press'))
    assert node.job('A-rest').unavailable == (conveyor,)
    assert f'it needs {conveyor}, which is out of service' in message


def test_7_6_rest_waits_in_stopped_cell(node: Node) -> None:
    node.order('A', 5)
    node.run.go(until=3.0)
    assert node.run.command(Stop).accepted
    message = node.requeued('A', at('press'))
    assert 'the cell waits for' in message
    node.run.go()
    assert node.queue == ['A-rest']
    assert node.run.command(Reset).accepted
    assert node.run.command(Start).accepted
    node.run.go()
    assert node.run.state.ended['A-rest'].exit_status == 'completed'
