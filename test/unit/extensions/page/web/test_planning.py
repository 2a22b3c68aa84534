"""A planner's questions over HTTP: what would be, whether an order is right, the whole queue."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from fakes.browser import Answered, Browser
from fakes.line import THREE, expanded
from fakes.queued_jobs import LINE, queued
from starlette.applications import Starlette
from starlette.middleware import Middleware

from bt_orchestrator.base.errors import CommandRefused, NodeUnreachable, NotKept
from bt_orchestrator.cli.processes.planning_process import PlanningProcess
from bt_orchestrator.extensions.page.web.access import Access
from bt_orchestrator.extensions.page.web.endpoint import routes
from bt_orchestrator.extensions.page.web.guards import GuardMiddleware
from bt_orchestrator.extensions.page.web.people import People
from bt_orchestrator.extensions.page.web.planning.endpoints import endpoints
from bt_orchestrator.extensions.page.web.planning.questions import (
    MOST_WAITING,
    Questions,
    Withdrawn,
)
from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.model.keeping.snapshot import state_to_plain
from bt_orchestrator.model.limits import QUEUE_SHOWN
from bt_orchestrator.model.requests import Asked
from bt_orchestrator.model.status import JobStatus
from bt_orchestrator.ports import (
    CheckedOrder,
    Consequence,
    ExpectedJob,
    Moment,
    Proposal,
    ProposedJob,
    QueuePage,
    WrongField,
)
from bt_orchestrator.script.orders.order_file import wrong_quantity

NOW_S = 1000.0
ORDER = {'script': 'other', 'order': 'WO-9', 'quantity': 2, 'params': {'lot': '5'}}
SCRIPT = expanded(f'script: other\nparams: {{lot: {{type: str}}}}\n{THREE}')

PROPOSAL = Proposal(
    (
        ProposedJob('B', 2, 1, 0, 1030.0, 40.0, 20.0),
        ProposedJob('A', 1, 2, 0, None, 20.0, None, 'A is held in the queue'),
    ),
    'd1ge57',
    10.0,
    0.0,
    looked_at=2,
    orders=2,
    is_best=True,
    unknown={'A': 'A is held in the queue'},
)


TOO_MANY = WrongField('quantity', *wrong_quantity(99, 9))


class Planned:
    """Notes what was asked. Implements `ports.Planning`."""

    def __init__(self) -> None:
        self.asked: list[Sequence[Asked]] = []
        self.checked: list[Mapping[str, object]] = []
        self.proposal = PROPOSAL
        self.why_not = ''
        self.is_closed = False

    def what_if(self, moment: Moment, requests: Sequence[Asked]) -> Consequence:
        self._refuse(moment)
        self.asked.append(requests)
        before = [ExpectedJob('A', 10.0), ExpectedJob('B', None)]
        return Consequence(before, before[:1], ['job.next: no'], due_s={'A': 8.0})

    def propose(self, moment: Moment) -> Proposal:
        self._refuse(moment)
        return self.proposal

    def check(self, moment: Moment, order: Mapping[str, object]) -> CheckedOrder:
        self._refuse(moment)
        self.checked.append(order)
        return CheckedOrder(False, '1 mistake', (TOO_MANY,))

    def close(self) -> None:
        self.is_closed = True

    def _refuse(self, moment: Moment) -> None:
        assert moment.now_s == NOW_S
        if self.why_not:
            raise NotKept(self.why_not)


class LongQueue:
    """Some jobs. Implements `endpoints.Queue`."""

    def __init__(self, queued: int) -> None:
        self.queued = queued
        self.is_silent = False

    async def page(self, after: str, most: int) -> QueuePage:
        if self.is_silent:
            raise NodeUnreachable('it is silent')
        names = [f'J{number}' for number in range(1, self.queued + 1)]
        if after and after not in names:
            raise CommandRefused(f'{after} is not in the queue')
        first = names.index(after) + 1 if after else 0
        places = range(first + 1, min(first + most, self.queued) + 1)
        word = JobWord.ALLOWED_TO_START
        return QueuePage([JobStatus(f'J{n}', 's', word, position=n) for n in places], self.queued)

    def shown(self, jobs: Sequence[JobStatus]) -> Sequence[object]:
        return [{'id': job.id} for job in jobs]


class Bench:
    """The routes of a planner, and a browser."""

    def __init__(self, queued: int = 3, *, plans: bool = True) -> None:
        self.loop = asyncio.new_event_loop()
        self.planned, self.queue = Planned(), LongQueue(queued)
        self.questions = Questions(self.planned if plans else None, self._moment)
        self.app = Starlette(
            routes=routes(endpoints(self.questions, self.queue)),
            middleware=[
                Middleware(GuardMiddleware, people=People(Access(Path(), local_user='ann')))
            ],
        )
        self.browser = Browser(self.app, self.loop)
        self.may_go_on: asyncio.Event | None = None

    async def _moment(self) -> Moment:
        if self.may_go_on is not None:
            await self.may_go_on.wait()
        return Moment(LINE.cell, {}, NOW_S)

    def close(self) -> None:
        self.loop.run_until_complete(self.loop.shutdown_default_executor())
        self.loop.close()

    def what_if(self, *commands: object) -> Answered:
        return self.browser.post('/api/what-if', {'commands': list(commands)})


@pytest.fixture
def bench() -> Iterator[Bench]:
    with closing(Bench()) as new_bench:
        yield new_bench


def test_proposed_order_carries_its_offer(bench: Bench) -> None:
    bench.queue.queued = QUEUE_SHOWN + 2
    answer = bench.browser.post('/api/queue/propose', {})
    assert answer.status == 200
    proposal = answer.json
    first, second = proposal['jobs']
    assert first == {
        'job': 'B',
        'place': 2,
        'new_place': 1,
        'priority': 0,
        'due': 1030.0,
        'stays': '',
        'ends': 1040.0,
        'new_ends': 1020.0,
    }
    assert (second['ends'], second['new_ends']) == (1020.0, None)
    assert (proposal['late_s'], proposal['new_late_s'], proposal['is_best']) == (10.0, 0.0, True)
    assert proposal['unknown'] == {
        'A': {
            'en': 'A is held in the queue',
            'de': 'A ist in der Warteschlange zurückgehalten',
        }
    }
    assert proposal['left_out'] == 2
    offer, order = proposal['offer'], {'jobs': ['B', 'A'], 'queue_digest': 'd1ge57'}
    assert offer['path'] == '/api/requests/queue.arrange'
    assert (offer['body'], offer['parameters']) == (order, [])
    assert offer['foresee'] == {'name': 'queue.arrange', 'arguments': order}
    assert offer['roles'] == ['operate', 'engineer']


def test_best_queue_order_has_no_offer(bench: Bench) -> None:
    jobs = [job._replace(new_place=job.place) for job in reversed(PROPOSAL.jobs)]
    bench.planned.proposal = PROPOSAL._replace(jobs=jobs)
    assert bench.browser.post('/api/queue/propose', {}).json['offer'] is None
    bench.planned.why_not = 'the state cannot be told'
    assert bench.browser.post('/api/queue/propose', {}).status == 503


def test_ends_are_told_as_times(bench: Bench) -> None:
    answer = bench.what_if({'name': 'job.next', 'arguments': {'job': 'B'}})
    assert answer.status == 200
    assert answer.json.pop('computed_s') >= 0
    forecast = answer.json
    assert forecast['before'] == [{'job': 'A', 'ends': 1010.0}, {'job': 'B', 'ends': None}]
    assert forecast['after'] == [{'job': 'A', 'ends': 1010.0}]
    late = {'due': 1008.0, 'is_late': True, 'was_late': True}
    timely = {'due': None, 'is_late': False, 'was_late': False}
    assert forecast['jobs'] == [
        {'job': 'A', 'change': 'same', 'before': 1010.0, 'after': 1010.0, 'by_s': 0.0, **late},
        {'job': 'B', 'change': 'gone', 'before': None, 'by_s': None, **timely},
    ]
    assert forecast['refusals'] == ['job.next: no']
    assert forecast['refusals_said'] == [{'de': 'no', 'en': 'no'}]
    assert forecast['left_out'] == 0
    ((asked,),) = bench.planned.asked
    assert (asked.request.name, dict(asked.arguments)) == ('job.next', {'job': 'B'})
    assert asked.sender.reason, 'a request that needs a reason is not refused for that'


def test_an_order_is_read_before_it_is_asked(bench: Bench) -> None:
    command = {'name': 'queue.add', 'arguments': {'orders': [ORDER], 'position': 1}}
    assert bench.what_if(command).status == 200
    ((asked,),) = bench.planned.asked
    orders: Any = asked.arguments['orders']
    assert (orders[0].order, orders[0].params) == ('WO-9', {'lot': '5'})
    assert asked.arguments['position'] == 1


@pytest.mark.parametrize(
    ('command', 'words'),
    [
        ('job.next', 'an object with the name of a request'),
        ({'name': 7}, 'an object with the name of a request'),
        ({'name': 'job.fly'}, "there is no request 'job.fly'"),
        ({'name': 'job.next'}, 'needs job'),
        ({'name': 'job.next', 'arguments': ['B']}, 'are an object'),
        ({'name': 'job.next', 'arguments': {'job': 'B', 'by': 'eve'}}, 'does not take'),
        ({'name': 'job.move', 'arguments': {'job': 'B', 'position': 'x'}}, 'whole number'),
        ({'name': 'queue.add', 'arguments': {'orders': 7}}, 'a list of objects'),
        ({'name': 'queue.add', 'arguments': {'orders': [{}]}}, 'needs the key `script`'),
    ],
)
def test_what_is_no_command_is_told(bench: Bench, command: object, words: str) -> None:
    answer = bench.what_if(command)
    assert answer.status == 422
    assert words in answer.message
    assert bench.planned.asked == []


@pytest.mark.parametrize('body', [{}, {'commands': 7}, {'commands': [{'name': 'x'}] * 51}])
def test_commands_are_a_list(bench: Bench, body: object) -> None:
    assert bench.browser.post('/api/what-if', body).status == 422


def test_an_order_is_checked(bench: Bench) -> None:
    answer = bench.browser.post('/api/orders/check', {'order': ORDER})
    assert answer.json == {
        'accepted': False,
        'is_checked': True,
        'message': '1 mistake',
        'said': {'de': '1 mistake', 'en': '1 mistake'},
        'findings': [
            {
                'field': 'quantity',
                'what': '`quantity` is 99, and an order of this cell has at most 9 items',
                'hint': 'order less at a time, or raise `most_items` in the cell file',
                'said': {
                    'en': '`quantity` is 99, and an order of this cell has at most 9 items; '
                    'order less at a time, or raise `most_items` in the cell file',
                    'de': '99 Teile sind zu viele: Ein Auftrag dieser Zelle hat höchstens 9; '
                    'weniger auf einmal bestellen, oder `most_items` in der Zellendatei erhöhen',
                },
            }
        ],
    }
    assert bench.planned.checked == [ORDER]
    assert bench.browser.post('/api/orders/check', {'order': 'WO-9'}).status == 422


def test_why_nothing_can_be_worked_out(bench: Bench) -> None:
    bench.planned.why_not = 'the process ended'
    for answer in (
        bench.what_if(),
        bench.browser.post('/api/orders/check', {'order': ORDER}),
    ):
        assert (answer.status, answer.message) == (503, 'the process ended')


def test_a_page_without_planning_says_so() -> None:
    with closing(Bench(plans=False)) as bench:
        answer = bench.what_if()
        assert (answer.status, answer.message) == (503, 'this page works nothing out')
        bench.questions.close()


def test_only_some_questions_wait(bench: Bench) -> None:
    async def crowd() -> list[Answered]:
        bench.may_go_on = asyncio.Event()
        body: dict[str, list[object]] = {'commands': []}
        asked = [
            asyncio.ensure_future(bench.browser.posted('/api/what-if', body))
            for _ in range(MOST_WAITING + 1)
        ]
        await asyncio.wait(asked, return_when=asyncio.FIRST_COMPLETED)
        bench.may_go_on.set()
        return list(await asyncio.gather(*asked))

    statuses = [answer.status for answer in bench.loop.run_until_complete(crowd())]
    assert sorted(statuses) == [200] * MOST_WAITING + [503]
    assert bench.what_if().status == 200, 'there is room again'


def test_what_nobody_waits_for_is_not_worked_out(bench: Bench) -> None:
    async def is_gone() -> bool:
        return True

    with pytest.raises(Withdrawn):
        bench.loop.run_until_complete(bench.questions.what_if([], 0, is_gone))
    assert bench.planned.asked == []
    assert bench.what_if().status == 200, 'the turn goes on'


def test_the_queue_by_pages() -> None:
    with closing(Bench(queued=QUEUE_SHOWN + 7)) as bench:
        first = bench.browser.get('/api/queue').json
        assert len(first['jobs']) == QUEUE_SHOWN
        assert (first['queued'], first['rest']) == (QUEUE_SHOWN + 7, f'J{QUEUE_SHOWN}')
        rest = bench.browser.get(f'/api/queue?after={first["rest"]}').json
        assert [job['id'] for job in rest['jobs']] == [f'J{QUEUE_SHOWN + n}' for n in range(1, 8)]
        assert rest['rest'] is None
        gone = bench.browser.get('/api/queue?after=gone')
        assert (gone.status, gone.message) == (409, 'gone is not in the queue')
        bench.queue.is_silent = True
        assert bench.browser.get('/api/queue').status == 503
        assert bench.what_if().json['left_out'] == 7, 'a moment has the first jobs alone'


def test_planning_ends_with_the_page(bench: Bench) -> None:
    bench.questions.close()
    assert bench.planned.is_closed


@pytest.mark.parametrize(('lot', 'is_fine'), [('5', True), (None, False)])
def test_planning_process_reads_order_and_asks_engine(
    tmp_path: Path, lot: str | None, *, is_fine: bool
) -> None:
    """The one test here with the process itself."""
    (tmp_path / 'other.yaml').write_text(SCRIPT)
    run = queued('K')
    moment = Moment(LINE.cell, state_to_plain(run.state), run.now)
    order = {**ORDER, 'params': {} if lot is None else {'lot': lot}}
    with closing(PlanningProcess([tmp_path])) as planning:
        assert planning.check(moment, order).accepted is is_fine
        assert [mistake.field for mistake in planning.check(moment, order).wrong] == (
            [] if is_fine else ['params.lot']
        )
