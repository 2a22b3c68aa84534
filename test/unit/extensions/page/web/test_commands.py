"""Every request of the table, for every role, posted to the page; the journal is looked at.

A request that is new in the table is tested as well.
"""

from __future__ import annotations

import asyncio
import itertools
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fakes.browser import Answered, Browser
from fakes.page_bench import ROLES, CellBench
from fakes.quick_users import PASSWORD

from bt_orchestrator.extensions.page.web.access import IDLE_S
from bt_orchestrator.model.by import Role
from bt_orchestrator.model.limits import REASON
from bt_orchestrator.model.requests import REQUESTS, TABLE, About, Kind, Request, Why
from bt_orchestrator.ports.doors.tickets import SETTLED_S
from bt_orchestrator.store.memory import MemoryStore

SUBJECTS = {About.JOB: 'WO-1', About.ITEM: 'WO-1/1', About.HOLD: '1'}

VALUES = {
    Kind.WHOLE: 1,
    Kind.TEXT: 'd1ge57',
    Kind.TEXTS: ['WO-1'],
    Kind.ORDERS: [{'order': 'WO-7', 'script': 'small', 'quantity': 1}],
}
"""Of parameters that a request cannot do without."""

_tickets = itertools.count(1)

every_request = pytest.mark.parametrize('request_', TABLE, ids=lambda case: case.name)


def new_ticket() -> str:
    return f'{next(_tickets):016x}'


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[CellBench]:
    made = CellBench(tmp_path)
    yield made
    made.close()


def body_of(request: Request, **more: Any) -> tuple[str, dict[str, Any]]:
    subject = SUBJECTS.get(request.about, '')
    about = {request.subject.name: subject} if request.subject else {}
    needed = {
        parameter.name: VALUES[parameter.kind]
        for parameter in request.parameters
        if parameter.is_required and parameter is not request.subject
    }
    path = f'/api/requests/{request.name}'
    return path, {**about, **needed, 'reason': 'a test', 'ticket': new_ticket(), **more}


def post(browser: Browser, request: Request, **more: Any) -> Answered:
    return browser.post(*body_of(request, **more))


def add(browser: Browser, *orders: str, **more: Any) -> Answered:
    plain = [{'order': order, 'script': 'small', 'quantity': 1} for order in orders]
    return browser.post('/api/queue/add', {'orders': plain, **more})


# --- each request for each role -----------------------------------------------------------------


@every_request
@pytest.mark.parametrize('name', ROLES)
def test_requests_obey_roles_of_table(bench: CellBench, request_: Request, name: str) -> None:
    browser, before = bench.logged_in(name), len(bench.journal)
    path, body = body_of(request_, who='the boss', role='engineer')
    body.pop('role')
    answer = browser.post(path, body)
    if ROLES[name] not in request_.roles:
        assert answer.status == 403
        assert f'{request_.name} is for the role' in answer.message
        assert f'{name} has the role {ROLES[name].value} (page login)' in answer.message
        assert len(bench.journal) == before, 'nothing was asked of the cell'
        return
    assert answer.status in (200, 409), answer.body
    assert answer.json['accepted'] is (answer.status == 200)
    recorded = bench.commands[-1]
    assert recorded.who == name
    assert recorded.origin == f'page {body["ticket"]}'
    assert (recorded.role, recorded.known) == (ROLES[name].value, 'page login')
    assert recorded.reason == 'a test'
    assert answer.json['recorded']['seq'] == recorded.seq
    assert answer.json['who'] == name


def test_refusal_is_kept_in_every_language(
    bench: CellBench,
) -> None:
    viewer, ann = bench.logged_in('vic'), bench.logged_in('ann')
    path, body = body_of(REQUESTS['job.next'], job='WO-9')
    answer = ann.post(path, body)
    texts = {
        'en': 'WO-9 is not there; in the queue: nothing',
        'de': 'WO-9 ist nicht da; in der Warteschlange: nichts',
    }
    assert (answer.status, answer.message, answer.json['said']) == (409, texts['en'], texts)
    assert ann.get(f'/api/tickets/{body["ticket"]}').json['said'] == texts
    refused = post(viewer, REQUESTS['cell.start'])
    assert refused.json['said']['de'] == (
        '„Start“ ist nur für Bediener oder Techniker, und vic hat die Rolle Zuschauer (Anmeldung '
        'an der Seite); es ist nichts geschehen'
    )


@every_request
def test_an_argument_that_no_request_has_is_refused(bench: CellBench, request_: Request) -> None:
    wrong = post(bench.logged_in('eve'), request_, height=3)
    assert wrong.status == 422
    assert 'found height' in wrong.message


def test_unknown_request_name_is_refused(bench: CellBench) -> None:
    answer = bench.logged_in('eve').post('/api/requests/cell.fly', {'reason': 'a test'})
    assert answer.status == 422
    assert answer.message.startswith('name is one of cell.reset, ')


WRONG = (
    {'cookie': 'bt_orchestrator_8080=guessed'},
    {'origin': 'http://evil.example.org'},
    {'origin': ''},
    {'host': 'evil.example.org'},
    {'content_type': 'text/plain'},
)


@every_request
def test_requests_not_from_page_are_refused(bench: CellBench, request_: Request) -> None:
    before = len(bench.journal)
    for name in ROLES:
        browser = bench.logged_in(name)
        for wrong in WRONG:
            answer = browser.post(*body_of(request_), **wrong)
            assert answer.status in (401, 403, 415), (name, wrong)
            assert answer.message
    assert len(bench.journal) == before
    assert not bench.doors.asked


@every_request
def test_without_a_session_nothing_is_asked(bench: CellBench, request_: Request) -> None:
    answer = post(bench.browser(), request_)
    assert (answer.status, answer.json['why']) == (401, 'login')
    assert not bench.doors.asked


@every_request
def test_a_locked_session_is_for_emergencies(bench: CellBench, request_: Request) -> None:
    browser = bench.logged_in('eve')
    bench.now += IDLE_S
    answer = post(browser, request_)
    if request_.why is Why.AFTERWARDS:
        assert answer.status in (200, 409)
        assert bench.commands[-1].origin.endswith(', locked session')
    else:
        assert (answer.status, answer.json['why']) == (403, 'locked')
        assert not bench.doors.asked
        browser.post('/api/unlock', {'password': PASSWORD})
        assert post(browser, request_).status in (200, 409)


@every_request
def test_reason_is_required_as_table_says(bench: CellBench, request_: Request) -> None:
    browser = bench.logged_in('eve')
    answer = post(browser, request_, reason='  ')
    if request_.why is Why.FIRST:
        assert (answer.status, len(bench.doors.asked)) == (422, 0)
        assert 'needs a reason' in answer.message
    else:
        assert answer.status in (200, 409)


def test_the_emergencies_are_abort_pause_and_stop() -> None:
    assert {request.name for request in TABLE if request.why is Why.AFTERWARDS} == {
        'cell.abort',
        'cell.pause',
        'cell.stop',
        'component.cancel_task',
    }


@every_request
def test_silent_node_gets_only_emergency_commands(bench: CellBench, request_: Request) -> None:
    browser = bench.logged_in('eve')
    bench.doors.is_silent = True
    bench.doors.loses_answers = True
    answer = post(browser, request_)
    assert answer.status == 503
    assert answer.json['is_unknown'] is (request_.why is Why.AFTERWARDS)
    assert bool(bench.doors.asked) is (request_.why is Why.AFTERWARDS)


@every_request
def test_an_unknown_argument_is_refused(bench: CellBench, request_: Request) -> None:
    answer = post(bench.logged_in('eve'), request_, nonsense=1)
    assert answer.status == 422
    assert 'nonsense' in answer.message
    assert not bench.doors.asked


def test_trusted_computer_is_recorded_as_claim(tmp_path: Path) -> None:
    bench = CellBench(tmp_path, local_user='pat')
    assert bench.browser().post('/api/cell/abort', {}).status == 200
    recorded = bench.commands[-1]
    assert (recorded.who, recorded.known) == ('pat', 'ros unauthenticated')
    bench.close()


def test_role_ignored_by_node_is_reported(bench: CellBench) -> None:
    """As over ROS, to a node without trust_local_doors."""
    browser = bench.logged_in('ann')
    real = bench.doors.ask

    async def distrusting(asked: Any) -> Any:
        import dataclasses

        from bt_orchestrator.model.by import Known

        by = dataclasses.replace(
            asked.by, role=Role.ENGINEER, known=Known.ROS, claims='operate (page login)'
        )
        return await real(dataclasses.replace(asked, by=by))

    bench.doors.ask = distrusting  # type: ignore[method-assign]
    answer = browser.post('/api/cell/abort', {'reason': 'smoke'}).json
    assert answer['recorded']['claims'] == 'operate (page login)'
    assert 'records operate (page login) as a claim' in answer['note']
    assert 'trust_local_doors' in answer['note']


# --- what is in a body --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ('path', 'body', 'message'),
    [
        ('/api/cell/explode', {}, 'command is one of reset, start'),
        ('/api/cell/abort', {'reason': 1}, 'reason is a text'),
        ('/api/cell/abort', {'reason': 'x' * (REASON + 1)}, 'reason is a text of at most 2000'),
        ('/api/cell/abort', {'ticket': 'abc'}, 'ticket is 16 hexadecimal digits'),
        ('/api/cell/abort', {'ticket': 'ABCDEF0123456789'}, 'ticket is 16 hexadecimal digits'),
        ('/api/cell/abort', {'ticket': ['0' * 16]}, 'ticket is 16 hexadecimal digits'),
        ('/api/cell/resume', {'reason': 'r', 'everyones': 1}, 'everyones of cell.resume is yes'),
        ('/api/queue/move', {'reason': 'r', 'job': 'WO-1'}, 'job.move needs position'),
        ('/api/queue/move', {'reason': 'r', 'job': 'W', 'position': True}, 'is whole number'),
        ('/api/queue/update', {'reason': 'r', 'job': 'x' * 201}, 'job has 201 characters'),
        (
            '/api/holds/' + 'x' * 201 + '/answer',
            {'reason': 'r', 'answer': 'retry'},
            'hold has 201',
        ),
        ('/api/queue/add', {}, 'orders is a list of 1 to 250 work orders'),
        ('/api/queue/add', {'orders': []}, 'orders is a list'),
        ('/api/queue/add', {'orders': [1]}, 'each work order is an object'),
        ('/api/queue/add', {'orders': [{'script': 'small'}]}, 'needs an id of its own'),
        ('/api/queue/add', {'orders': [{'order': 'WO-1', 'scrap': 1}]}, 'scrap'),
    ],
)
def test_invalid_input_is_reported_and_not_sent(
    bench: CellBench, path: str, body: dict[str, Any], message: str
) -> None:
    answer = bench.logged_in('eve').post(path, body)
    assert answer.status == 422
    assert message in answer.message
    assert not bench.doors.asked


def test_an_mes_gives_a_job_no_other_script(bench: CellBench) -> None:
    browser = bench.logged_in('mes')
    body = {'job': 'WO-1', 'script': 'small', 'reason': 'r'}
    answer = browser.post('/api/queue/update', body)
    assert answer.status == 403
    assert 'job.update with script is for the role engineer' in answer.message


def test_orders_are_queued_and_missing_script_reported(bench: CellBench) -> None:
    browser = bench.logged_in('mes')
    assert add(browser, 'WO-1', 'WO-2', held=True).json['accepted']
    assert [job.id for job in bench.node.running.overview.status(0.0).jobs] == ['WO-1', 'WO-2']
    refused = browser.post('/api/queue/add', {'orders': [{'order': 'WO-3', 'script': 'gone'}]})
    assert refused.status == 409
    assert any('gone' in finding for finding in refused.json['findings'])
    assert refused.json['recorded']['seq'] == bench.commands[-1].seq


def test_repeated_order_id_is_refused(bench: CellBench) -> None:
    browser = bench.logged_in('mes')
    assert add(browser, 'WO-1', held=True).status == 200
    again = add(browser, 'WO-1', held=True)
    assert again.status == 409
    assert 'WO-1' in again.json['message']


# --- tickets ------------------------------------------------------------------------------------


def test_repeated_ticket_is_answered_without_second_execution(bench: CellBench) -> None:
    browser, ticket = bench.logged_in('ann'), new_ticket()
    first = browser.post('/api/cell/abort', {'ticket': ticket})
    again = browser.post('/api/cell/abort', {'ticket': ticket})
    assert (first.status, first.body) == (again.status, again.body)
    assert len(bench.doors.asked) == 1
    assert len(bench.commands) == 1


def test_the_same_ticket_at_the_same_time(bench: CellBench) -> None:
    browser, ticket = bench.logged_in('mes'), new_ticket()
    orders = [{'order': 'WO-1', 'script': 'small', 'quantity': 1}]

    async def twice() -> list[Answered]:
        bench.doors.gate = asyncio.Event()
        body = {'orders': orders, 'ticket': ticket, 'held': True}
        both = [asyncio.ensure_future(browser.posted('/api/queue/add', body)) for _ in range(2)]
        while not bench.doors.asked:
            await asyncio.sleep(0)
        bench.doors.gate.set()
        return await asyncio.gather(*both)

    first, second = bench.loop.run_until_complete(twice())
    assert first.body == second.body
    assert first.json['accepted']
    assert len(bench.doors.asked) == 1


def test_ticket_belongs_to_one_command_and_person(bench: CellBench) -> None:
    ticket = new_ticket()
    assert bench.logged_in('ann').post('/api/cell/abort', {'ticket': ticket}).status == 200
    other = bench.logged_in('ann').post('/api/cell/stop', {'ticket': ticket})
    assert (other.status, len(bench.doors.asked)) == (422, 1)
    assert bench.logged_in('eve').post('/api/cell/abort', {'ticket': ticket}).status == 422
    assert 'is of another command' in other.message


def test_without_a_ticket_the_page_makes_one(bench: CellBench) -> None:
    browser = bench.logged_in('ann')
    tickets = {browser.post('/api/cell/abort', {}).json['ticket'] for _ in range(2)}
    assert len(tickets) == 2
    assert all(browser.get(f'/api/tickets/{ticket}').json['found'] for ticket in tickets)


def test_lost_answer_is_found_in_journal(bench: CellBench) -> None:
    browser, ticket = bench.logged_in('ann'), new_ticket()
    bench.doors.loses_answers = True
    lost = browser.post('/api/cell/abort', {'ticket': ticket, 'reason': 'smoke'})
    assert (lost.status, lost.json['is_unknown'], lost.json['ticket']) == (503, True, ticket)
    assert 'whether it was carried out is not known' in lost.message
    bench.doors.loses_answers = False
    result = browser.get(f'/api/tickets/{ticket}').json
    assert (result['found'], result['accepted'], result['who']) == (True, True, 'ann')
    assert result['seq'] == bench.commands[-1].seq
    assert result['message'] == 'ann decided abort'
    again = browser.post('/api/cell/abort', {'ticket': ticket, 'reason': 'smoke'})
    assert (again.status, again.json['seq']) == (200, result['seq'])
    assert len(bench.doors.asked) == 1, 'it was not done twice'


def test_undelivered_command_is_repeated_later(bench: CellBench) -> None:
    browser, ticket = bench.logged_in('ann'), new_ticket()
    browser.post('/api/cell/pause', {})
    bench.node.switch_off()
    assert browser.post('/api/cell/abort', {'ticket': ticket}).json['is_unknown']
    searched = browser.get(f'/api/tickets/{ticket}').json
    assert (searched['found'], searched['node_silent']) == (False, True)
    bench.node.switch_on(bench.store)
    searched = browser.get(f'/api/tickets/{ticket}').json
    assert (searched['found'], searched['node_silent']) == (False, False)
    assert searched['looked_to'] == bench.journal[-1].seq
    again = browser.post('/api/cell/abort', {'ticket': ticket})
    assert (again.status, again.json['is_unknown'], len(bench.doors.asked)) == (503, True, 2)
    assert 'ask again in 10 s' in again.message, 'it might still be on its way'
    bench.now += SETTLED_S
    assert browser.post('/api/cell/abort', {'ticket': ticket}).status == 200
    assert browser.post('/api/cell/abort', {'ticket': ticket}).status == 200
    assert len(bench.doors.asked) == 3, 'once'
    assert len([command for command in bench.commands if ticket in command.origin]) == 1


def test_journal_answers_tickets_after_page_restart(bench: CellBench) -> None:
    browser, done, refused = bench.logged_in('mes'), new_ticket(), new_ticket()
    assert add(browser, 'WO-1', 'WO-2', ticket=done, held=True).status == 200
    assert add(browser, 'WO-1', ticket=refused).status == 409
    bench.restart_page()
    browser = bench.logged_in('mes')
    result = browser.get(f'/api/tickets/{done}').json
    assert (result['found'], result['accepted']) == (True, True)
    assert result['message'] == 'mes decided add: WO-1; mes decided add: WO-2'
    result = browser.get(f'/api/tickets/{refused}').json
    assert (result['found'], result['accepted']) == (True, False)
    assert 'WO-1' in result['message']
    before = len(bench.journal)
    assert add(browser, 'WO-1', 'WO-2', ticket=done, held=True).status == 200
    assert add(browser, 'WO-1', ticket=refused).status == 409
    assert len(bench.journal) == before, 'nothing was done again'
    other = {'ticket': done, 'reason': 'r', 'job': 'WO-1'}
    assert browser.post('/api/queue/command', {**other, 'command': 'cancel'}).status == 422


def test_a_ticket_that_nobody_has(bench: CellBench) -> None:
    browser = bench.logged_in('ann')
    assert browser.get('/api/tickets/nonsense').status == 422
    searched = browser.get(f'/api/tickets/{new_ticket()}').json
    assert not searched['found']


def test_another_journal_has_other_numbers(bench: CellBench) -> None:
    """A node without a journal file begins anew: then old tickets are gone, and say so."""
    browser, ticket = bench.logged_in('ann'), new_ticket()
    for _ in range(5):
        browser.post('/api/cell/abort', {})
    bench.doors.loses_answers = True
    browser.post('/api/cell/abort', {'ticket': ticket})
    bench.node.switch_off()
    bench.store = MemoryStore()
    bench.node.switch_on(bench.store)
    searched = browser.get(f'/api/tickets/{ticket}').json
    assert (searched['found'], searched['node_silent']) == (False, False)
