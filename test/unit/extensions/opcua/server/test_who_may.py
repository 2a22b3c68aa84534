"""Every method of the server, called by every role: what a role may not do leaves no trace."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator, Iterator
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path
from typing import Any, NamedTuple

import asyncua
import pytest
from asyncua import ua
from fakes.opcua_access import ROLES, with_login
from fakes.who_may import differences
from opcua_reader import Reader, client_of
from opcua_stand import opcua_stand
from web.stand_cell import StandCell

from bt_orchestrator.extensions.opcua.mes.methods import REQUESTS
from bt_orchestrator.extensions.opcua.mes.plain_commands import verbs
from bt_orchestrator.model.by import Role
from bt_orchestrator.model.events import Event, OperatorDecided, OperatorRefused
from bt_orchestrator.model.jobs.order import WorkOrder
from bt_orchestrator.model.requests import About
from bt_orchestrator.store.memory import MemoryStore

DENIED = ua.StatusCodes.BadUserAccessDenied
ORDERED = 'WO-1'
USERS = {'vic': Role.VIEW, 'mes': Role.MES, 'ann': Role.OPERATE, 'eve': Role.ENGINEER}


class Scene(NamedTuple):
    """A cell with a job that has ended, and nothing to do."""

    cell: StandCell
    store: MemoryStore
    address: str

    @property
    def events(self) -> list[Event]:
        """The whole journal."""
        with self.cell.lock:
            return list(self.store.read())

    @asynccontextmanager
    async def user(self, name: str) -> AsyncIterator[Reader]:
        """Log in."""
        address = self.address.partition('@')[2]
        async with client_of(with_login(f'opc.tcp://{address}', name)) as client:
            await client.load_data_type_definitions()
            yield await Reader.of(client)


@pytest.fixture(scope='module')
def scene(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Scene]:
    store = MemoryStore()
    with opcua_stand(tmp_path_factory.mktemp('scene'), store=store) as (cell, server):
        setup = Scene(cell, store, server.address)

        async def at_rest() -> None:
            async with setup.user('eve') as reader:
                assert cell.queue(WorkOrder(cell.script, ORDERED, 1)).accepted
                await reader.wait('Simple/LastJob/ID', lambda value: value == ORDERED)
                await reader.wait('Simple/State', lambda value: value == 'Complete')

        asyncio.run(at_rest())
        yield setup


async def methods_below(node: asyncua.Node) -> AsyncIterator[tuple[asyncua.Node, asyncua.Node]]:
    """Yield every method of the address space of the cell, with the object that has it."""
    for below in await node.get_children(refs=ua.ObjectIds.HierarchicalReferences):
        kind = await below.read_node_class()
        if kind is ua.NodeClass.Method:
            yield node, below
        elif kind is ua.NodeClass.Object:
            async for pair in methods_below(below):
                yield pair


async def given_for(client: asyncua.Client, method: asyncua.Node) -> list[ua.Variant]:
    """Return arguments of the right types, which name the job that there is."""
    try:
        inputs = await (await method.get_child('0:InputArguments')).read_value()
    except ua.UaStatusCodeError:
        return []
    return [await _given(client, argument) for argument in inputs]


async def _given(client: asyncua.Client, argument: ua.Argument) -> ua.Variant:
    builtin = await asyncua.common.ua_utils.data_type_to_variant_type(
        client.get_node(argument.DataType)
    )
    is_list = argument.ValueRank >= 1
    value: Any
    if builtin is ua.VariantType.String:
        value = ORDERED
    elif builtin is ua.VariantType.ExtensionObject:
        value = ua.get_extensionobject_class_type(argument.DataType) or None
        value = value() if value else None
        if hasattr(value, 'JobOrderID'):
            value.JobOrderID = ORDERED
    else:
        value = ua.get_default_value(builtin)
    return ua.Variant([value] if is_list else value, builtin, is_array=is_list)


async def called(reader: Reader, above: asyncua.Node, method: asyncua.Node, *given: Any) -> int:
    request = ua.CallMethodRequest()
    request.ObjectId, request.MethodId = above.nodeid, method.nodeid
    request.InputArguments = list(given)
    (result,) = await reader.client.uaclient.call([request])
    return int(result.StatusCode.value)


def test_viewer_cannot_act_with_any_method(scene: Scene) -> None:
    async def work() -> None:
        tried = []
        async with scene.user('vic') as reader:
            before = scene.events
            (cell,) = [
                entry
                for entry in await reader.client.nodes.objects.get_children()
                if entry.nodeid.NamespaceIndex == reader.idx
            ]
            async for above, method in methods_below(cell):
                code = await called(reader, above, method, *await given_for(reader.client, method))
                tried.append((await method.read_browse_name()).Name)
                # What tells is good; what commands is denied, or has no such arguments.
                assert scene.events == before, f'{tried[-1]} did something ({code:x})'
        assert {'SubmitOrder', 'Command', 'AnswerHold'} <= set(tried)
        assert {entry.name for entry in REQUESTS} <= set(tried)
        assert len(tried) > 15, tried

    asyncio.run(work())


COMMANDS = [
    *((verb, '') for verb in verbs(About.CELL)),
    *((verb, ORDERED) for verb in verbs(About.JOB)),
]


@pytest.mark.parametrize('name', USERS)
def test_commands_are_denied_as_table_says(scene: Scene, name: str) -> None:
    async def work() -> None:
        async with scene.user(name) as reader:
            above, method = reader.node('Simple'), reader.node('Simple/Command')
            for request, job in COMMANDS:
                if ROLES[name] in request.roles:
                    continue
                before = scene.events
                given = (ua.Variant(value) for value in (request.word, job, 'because'))
                assert await called(reader, above, method, *given) == DENIED, request.name
                assert scene.events == before

    asyncio.run(work())


@pytest.mark.parametrize('method', REQUESTS, ids=lambda entry: entry.name)
def test_isa_95_methods_follow_roles_of_requests(scene: Scene, method: Any) -> None:
    async def work() -> None:
        for name, role in USERS.items():
            if role in REQUESTS[method].roles:
                continue
            async with scene.user(name) as reader:
                before, node = scene.events, reader.node(f'JobOrderControl/{method.name}')
                given = await given_for(reader.client, node)
                code = await called(reader, reader.node('JobOrderControl'), node, *given)
                assert code & 0xC0000000, f'{method.name} was Good for {name}'
                assert scene.events == before

    asyncio.run(work())


async def answer_to(reader: Reader, name: str, given: Any) -> str:
    """Return what the method for any request says."""
    try:
        _, message, findings = await reader.call('Simple/Request', name, json.dumps(given), 'why')
    except ua.UaStatusCodeError as error:
        denied = error.code == DENIED
        return f'{name} is for the role' if denied else str(error)
    return ' '.join([message, *findings])


def test_7_8_1_every_request_is_as_the_hand_written_table(tmp_path: Path) -> None:
    with opcua_stand(tmp_path) as (cell, server):
        cell.node.running.handler.why_no_panel = lambda: ''
        loop = asyncio.new_event_loop()
        address = server.address.partition('@')[2]
        names = {role: name for name, role in USERS.items()}
        readers: dict[str, Reader] = {}

        async def log_in(stack: AsyncExitStack) -> None:
            for name in (*USERS, *(f'panel_{value}' for value in USERS)):
                url = with_login(f'opc.tcp://{address}', name)
                client = await stack.enter_async_context(client_of(url))
                readers[name] = await Reader.of(client)

        def asked(name: str, given: Any, role: Role, is_panel: bool) -> str:
            reader = readers[f'{"panel_" if is_panel else ""}{names[role]}']
            return loop.run_until_complete(answer_to(reader, name, given))

        def hand_over(control: str) -> None:
            if cell.node.running.engine.state.control.value != control:
                answer = asked(f'cell.{control}', {}, Role.ENGINEER, True)
                assert answer.startswith(f'the line is in {control}'), answer

        def lose() -> None:
            with cell.lock:
                cell.node._gateway.say_of_safety('its value is False')
                cell.node.running.engine.settle()

        stack = AsyncExitStack()
        try:
            loop.run_until_complete(log_in(stack))
            assert list(differences(asked, hand_over, lose)) == []
            hand_over('local')
            control = readers['vic'].wait('Simple/Control', lambda value: value == 'local')
            loop.run_until_complete(control)
        finally:
            loop.run_until_complete(stack.aclose())
            loop.close()


def test_journal_records_user_proof_and_origin(scene: Scene) -> None:
    async def work() -> None:
        async with scene.user('ann') as reader:
            last = scene.events[-1].seq
            await reader.call('Simple/Command', 'stop', '', 'lunch')
        (decision,) = [
            event
            for event in scene.events
            if event.seq > last and isinstance(event, (OperatorDecided, OperatorRefused))
        ]
        assert (decision.who, decision.role, decision.known) == ('ann', 'operate', 'opc ua user')
        assert decision.reason == 'lunch'
        assert decision.origin.startswith('opcua ')
        assert decision.origin.endswith(' at 127.0.0.1')

    asyncio.run(work())
