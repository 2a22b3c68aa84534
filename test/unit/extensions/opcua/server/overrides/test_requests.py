"""Requests. Each test is of an override of asyncua, and fails without it."""

from __future__ import annotations

import pytest
from asyncua import ua
from fakes.guarded import Bench, Served, code_of
from fakes.opcua_access import ROLES
from fakes.opcua_clients import channel

from bt_orchestrator.extensions.opcua.server.overrides import limits

CODES = ua.StatusCodes


def test_requests_for_too_many_things_are_refused(insecure: Served) -> None:
    async def work(bench: Bench) -> None:
        async with bench.plain() as client:
            value = ua.ReadValueId(bench.variable.nodeid, ua.AttributeIds.Value)
            same = ua.ReadParameters(NodesToRead=[value] * (limits.SAME + 1))
            many = [ua.ReadValueId(ua.NodeId(number)) for number in range(limits.NODES + 1)]
            read = ua.ReadParameters(NodesToRead=many)
            call = [ua.CallMethodRequest(bench.method.nodeid, bench.method.nodeid, [])]
            path = ua.BrowsePath(bench.variable.nodeid)
            browse = ua.BrowseParameters(
                NodesToBrowse=[ua.BrowseDescription()] * (limits.BROWSED + 1)
            )
            write = ua.WriteParameters(NodesToWrite=[ua.WriteValue()] * (limits.NODES + 1))
            session = client.uaclient.session
            for work in (
                session.read(same), session.read(read), session.write(write),
                session.browse(browse),
                session.call(call * (limits.CALLED + 1)),
                session.translate_browsepaths_to_nodeids([path] * (limits.BROWSED + 1)),
            ):  # fmt: skip
                assert await code_of(work) == CODES.BadTooManyOperations
            assert not bench.callers

    insecure(work)


@pytest.mark.parametrize('name', ROLES)
def test_nobody_changes_the_address_space(insecure: Served, name: str) -> None:
    async def work(bench: Bench) -> None:
        async with bench.plain(name) as client:
            node = client.get_node(bench.variable.nodeid)
            assert await code_of(node.write_value(2)) == CODES.BadUserAccessDenied
            assert await code_of(node.delete()) == CODES.BadServiceUnsupported
            added = client.nodes.objects.add_folder(1, 'mine')
            assert await code_of(added) == CODES.BadServiceUnsupported

    insecure(work)


def test_nobody_registers_another_server_here(secure: Served) -> None:
    async def work(bench: Bench) -> None:
        client = bench.plain()
        async with channel(client):
            server = ua.RegisteredServer(ServerUri='urn:evil', ServerNames=[ua.LocalizedText('x')])
            params = ua.RegisterServer2Parameters(server)
            code = await code_of(client.uaclient.register_server2(params))
            assert code == CODES.BadServiceUnsupported
            assert 'urn:evil' not in bench.server.inside._known_servers

    secure(work)


@pytest.mark.parametrize(
    ('error', 'code'),
    [
        (ua.UaStatusCodeError(CODES.BadUserAccessDenied), CODES.BadUserAccessDenied),
        (RuntimeError('a defect'), CODES.BadInternalError),
    ],
)
def test_a_method_answers_what_it_raises(insecure: Served, error: Exception, code: int) -> None:
    async def work(bench: Bench) -> None:
        async with bench.plain() as client:
            bench.fails_with = error
            called = client.nodes.objects.call_method(client.get_node(bench.method.nodeid))
            assert await code_of(called) == code

    insecure(work)
