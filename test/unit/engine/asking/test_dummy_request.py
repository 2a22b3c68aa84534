"""A request that is only declared and decided is found at every door, and on record."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fakes.page_bench import CellBench
from fakes.request_bench import RequestBench

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.cli.main import main
from bt_orchestrator.cli.request import arguments_from
from bt_orchestrator.engine.runtime.deciding import DECIDERS, Decided, decides
from bt_orchestrator.extensions.page.web import request_paths
from bt_orchestrator.model.by import Role
from bt_orchestrator.model.requests import REQUESTS, About, Asked, Kind, Parameter, Request
from bt_orchestrator.model.requests.request import NAMED
from bt_orchestrator.model.state import CellState
from bt_orchestrator.model.words import sentence
from bt_orchestrator.ports.doors.tickets import Outcome

OIL = Request(
    'oil',
    About.COMPONENT,
    'records that a component was oiled',
    frozenset({Role.OPERATE, Role.ENGINEER}),
    False,
    (NAMED[About.COMPONENT], Parameter('drops', Kind.WHOLE, 'how many', span=(1, 9))),
)


def oil(_: CellState, asked: Asked, __: float) -> Decided:
    """Decide it."""
    if asked['component'] == 'lamp':
        raise CommandRefused(sentence('component_gone', component='lamp'))
    component, drops = asked['component'], asked.arguments.get('drops', 1)
    return f'{component} was oiled with {drops}', ()


@pytest.fixture(autouse=True)
def declared(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Add it to the table, as a row there does."""
    from bt_orchestrator.cli import request as verb
    from bt_orchestrator.model.requests import table

    rows = (*table.TABLE, OIL)
    for module in (table, request_paths, verb):
        monkeypatch.setattr(module, 'TABLE', rows)
    assert isinstance(REQUESTS, dict)
    monkeypatch.setitem(REQUESTS, OIL.name, OIL)
    decides(OIL)(oil)
    yield
    del DECIDERS[OIL.name]


def test_it_is_carried_out_and_on_record(tmp_path: Path) -> None:
    bench = RequestBench(tmp_path)
    answer = bench.ask_named('component.oil', '{component: arm, drops: 3}')
    assert answer.message == 'arm was oiled with 3'
    (decided,) = bench.records('operator.decided')
    assert (decided.answer, decided.component, decided.who) == ('oil', 'arm', 'Ann')
    for arguments, reason in (
        ('{component: lamp}', 'lamp is not in the cell file any more'),
        ('{component: arm, drops: 10}', 'drops of component.oil is a whole number from 1 to 9'),
        ('{drops: 1}', 'component.oil needs component'),
    ):
        answer = bench.ask_named('component.oil', arguments)
        assert not answer.accepted
        assert reason in answer.message
    assert len(bench.records('operator.refused')) == 3


def test_the_verb_lists_and_reads_it(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(['request']) == 0
    listed = capsys.readouterr().out
    assert 'records that a component was oiled (operate, engineer)' in listed
    assert '  drops=N: how many' in listed
    assert arguments_from(OIL, ['component=arm', 'drops=3']) == {'component': 'arm', 'drops': 3}


def test_the_page_takes_it(tmp_path: Path) -> None:
    bench = CellBench(tmp_path)
    posted = {'component': 'feeder', 'drops': 2, 'reason': 'it squeaks'}
    assert bench.logged_in('vic').post('/api/requests/component.oil', posted).status == 403
    answer = bench.logged_in('ann').post('/api/requests/component.oil', posted)
    assert answer.json['message'] == 'feeder was oiled with 2'
    assert bench.commands[-1].answer == 'oil'
    assert 'drops' in request_paths.body_at(request_paths.ANY)['body']
    bench.close()


def test_opc_ua_takes_it() -> None:
    pytest.importorskip('asyncua')
    from bt_orchestrator.extensions.opcua.server import calls as callers
    from bt_orchestrator.extensions.opcua.server import simple_commands
    from bt_orchestrator.model.by import By

    sent: list[Any] = []

    class Calls:
        async def ask(self, request: Request, arguments: Any, reason: str) -> Any:
            sent.append((request.name, dict(arguments), reason))
            return Outcome(True, 'done')

    class Bridge:
        calls = Calls()

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(callers, 'by_caller', lambda reason, _: By('Ann', 'opcua', reason))
        methods = simple_commands.SimpleCommands(Bridge())  # type: ignore[arg-type]
        arguments = json.dumps({'component': 'arm', 'drops': 3})
        outputs = asyncio.run(methods._request('component.oil', arguments, 'squeaks'))
    assert outputs[0].Value is True
    assert sent == [('component.oil', {'component': 'arm', 'drops': 3}, 'squeaks')]


def test_the_documentation_has_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(Path(__file__).parents[4] / 'docs'))
    from tables import requests

    monkeypatch.setattr(requests, 'TABLE', (OIL,))
    row = '\n'.join(requests.everything_that_can_be_asked())
    assert '`oil`' in row
    assert 'takes `drops`' in row


def test_ros_carries_it() -> None:
    pytest.importorskip('bt_orchestrator_interfaces')
    from fakes.request_bench import ANN

    from bt_orchestrator.model.requests import ask
    from bt_orchestrator.ros.link.requests import call_of

    call = call_of(ask('component.oil', ANN, component='arm'))
    assert (call.service, call.request.name) == ('request', 'component.oil')
