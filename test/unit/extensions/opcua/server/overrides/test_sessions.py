"""Sessions. Each test is of an override of asyncua, and fails without it."""

from __future__ import annotations

import asyncio

import asyncua
import pytest
from asyncua import ua
from fakes.guarded import Bench, Served, becomes, code_of
from fakes.opcua_clients import channel, watching

from bt_orchestrator.extensions.opcua.server.overrides import limits

CODES = ua.StatusCodes


def test_connection_has_one_session_and_leaves_none(insecure: Served) -> None:
    async def work(bench: Bench) -> None:
        client = bench.plain()
        async with channel(client):
            await client.create_session()
            assert await code_of(client.create_session()) == CODES.BadTooManySessions
        await becomes(lambda: not bench.server.inside.sessions)

    insecure(work)


def test_there_are_not_too_many_sessions(
    insecure: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(limits, 'SESSIONS', 1)

    async def work(bench: Bench) -> None:
        async with bench.plain():
            assert await code_of(bench.plain().connect()) == CODES.BadTooManySessions

    insecure(work)


def test_a_session_whose_client_is_gone_makes_room(
    insecure: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(limits, 'SESSIONS', 2)

    async def work(bench: Bench) -> None:
        gone = bench.plain()
        await gone.connect()
        await watching(bench, gone)
        gone.uaclient.disconnect_socket()
        await becomes(lambda: not bench.server.bserver.clients)
        assert len(bench.server.inside.sessions) == 1  # it may come back
        async with bench.plain(), bench.plain('ann'):
            names = [session.user.name for session in bench.server.inside.sessions]
            assert names == ['mes', 'ann']

    insecure(work)


def test_large_request_is_complete_without_blocking_others(
    insecure: Served,
) -> None:
    async def work(bench: Bench) -> None:
        async with bench.plain() as client, bench.plain('ann') as other:
            session, done = client.uaclient.session, []
            # A type with many subtypes.
            browse = ua.BrowseDescription(
                ua.NodeId(ua.ObjectIds.BaseEventType), ua.BrowseDirection.Forward,
                ua.NodeId(ua.ObjectIds.HierarchicalReferences), True,
            )  # fmt: skip
            wanted = ua.BrowseParameters(NodesToBrowse=[browse] * 60)

            async def large() -> None:
                results = await session.browse(wanted)
                done.append('large')
                assert len(results) == 60
                assert len({len(result.References) for result in results}) == 1

            async def small() -> None:
                await other.get_node(bench.variable.nodeid).read_value()
                done.append('small')

            await asyncio.gather(large(), small())
            assert done == ['small', 'large']

    insecure(work)


def test_the_token_of_a_session_cannot_be_guessed(insecure: Served) -> None:
    async def work(bench: Bench) -> None:
        async with bench.plain(), bench.plain('ann'):
            first, second = bench.server.inside.sessions
            for session in (first, second):
                assert isinstance(session.auth_token.Identifier, bytes)
                assert len(session.auth_token.Identifier) == 32
            assert first.auth_token != second.auth_token

    insecure(work)


def test_a_session_stays_with_its_user(insecure: Served) -> None:
    async def work(bench: Bench) -> None:
        async with bench.plain() as client:
            other = client.activate_session('ann', client._password)
            assert await code_of(other) == CODES.BadIdentityChangeNotSupported
            await client.nodes.objects.call_method(client.get_node(bench.method.nodeid))
            assert bench.callers[0].name == 'mes'

    insecure(work)


async def go_on(bench: Bench, former: asyncua.Client, name: str = 'mes') -> asyncua.Client:
    """Take the session of a client whose connection was cut to another connection."""
    client = bench.plain(name)
    await client.connect_socket()
    await client.send_hello()
    await client.open_secure_channel()
    client._policy_ids = former._policy_ids
    client._server_nonce = former._server_nonce
    client.security_policy.peer_certificate = former.security_policy.peer_certificate
    client.uaclient.protocol.authentication_token = former.uaclient.protocol.authentication_token
    await client.activate_session(name, client._password)
    return client


def test_session_moves_to_another_connection(insecure: Served) -> None:
    async def work(bench: Bench) -> None:
        async with bench.plain() as former:
            client = await go_on(bench, former)
            (session,) = bench.server.inside.sessions
            node = former.get_node(bench.variable.nodeid)
            assert await code_of(node.read_value()) == CODES.BadSecureChannelIdInvalid
            former.uaclient.disconnect_socket()
            await becomes(lambda: len(bench.server.bserver.clients) == 1)
            await asyncio.sleep(0)
            # asyncua would end the session with the connection that it has left.
            assert bench.server.inside.sessions == [session]
            assert session.is_open
            client.disconnect_socket()

    insecure(work)


def test_nobody_goes_on_with_the_session_of_another(insecure: Served) -> None:
    async def work(bench: Bench) -> None:
        async with bench.plain() as former:
            code = await code_of(go_on(bench, former, 'ann'))
            assert code == CODES.BadIdentityChangeNotSupported
            node = former.get_node(bench.variable.nodeid)
            assert await node.read_value() == 1

    insecure(work)
