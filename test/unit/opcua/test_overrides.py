"""Each override of asyncua, with asyncua's client or bytes: without it, its test fails."""

from __future__ import annotations

import asyncio
import struct
from collections.abc import Awaitable, Callable
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any

import asyncua
import pytest
from asyncua import ua
from asyncua.common.subscription import Subscription
from fakes.guarded import SOON_S, Bench, Served, becomes, code_of
from fakes.opcua_access import ROLES

from bt_orchestrator.opcua import asyncua_version
from bt_orchestrator.opcua.asyncua_version import OpcUaUnusable, check_version
from bt_orchestrator.opcua.overrides import limits
from bt_orchestrator.opcua.overrides.monitored import refused_filter
from bt_orchestrator.opcua.overrides.session import Session

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

CODES = ua.StatusCodes


class Heard:
    """What a subscription told."""

    def __init__(self) -> None:
        self.values: list[object] = []

    def datachange_notification(self, node: object, value: object, data: object) -> None:
        """Take note."""
        self.values.append(value)


async def watching(bench: Bench, client: asyncua.Client) -> tuple[Subscription, Heard]:
    heard = Heard()
    subscription = await client.create_subscription(50, heard)
    await subscription.subscribe_data_change(client.get_node(bench.variable.nodeid))
    await becomes(lambda: bool(heard.values))
    return subscription, heard


@asynccontextmanager
async def two(bench: Bench, other: str = 'ann') -> AsyncIterator[tuple[Any, Any, int]]:
    """Connect two users; the first has a subscription."""
    async with bench.plain() as first, bench.plain(other) as second:
        subscription, _ = await watching(bench, first)
        await second.create_subscription(500, Heard())
        yield first, second, subscription.subscription_id


# --- subscriptions ------------------------------------------------------------------------------


def test_republish_of_what_is_not_there_says_so(insecure: Served) -> None:
    async def work(bench: Bench) -> None:
        async with two(bench) as (first, _, own):
            session = first.uaclient.session
            assert await code_of(session.republish(own, 999)) == CODES.BadMessageNotAvailable
            assert await code_of(session.republish(12345, 1)) == CODES.BadSubscriptionIdInvalid

    insecure(work)


def test_republish_repeats_what_was_not_acknowledged_as_often_as_it_is_asked(
    insecure: Served,
) -> None:
    async def work(bench: Bench) -> None:
        async with two(bench) as (first, _, own):
            inside = bench.server.inside.subscription_service.subscriptions[own]
            inside._not_acknowledged_results[77] = ua.PublishResult()
            inside._not_acknowledged_results[77].NotificationMessage.SequenceNumber = 77
            for _ in range(2):
                told = await first.uaclient.session.republish(own, 77)
                assert told.SequenceNumber == 77

    insecure(work)


USES: dict[str, Callable[[Any, int], Awaitable[Any]]] = {
    'republish': lambda session, own: session.republish(own, 1),
    'modify': lambda session, own: session.update_subscription(
        ua.ModifySubscriptionParameters(SubscriptionId=own)
    ),
    'watch': lambda session, own: session.create_monitored_items(
        ua.CreateMonitoredItemsParameters(SubscriptionId=own)
    ),
    'change': lambda session, own: session.modify_monitored_items(
        ua.ModifyMonitoredItemsParameters(SubscriptionId=own)
    ),
    'forget': lambda session, own: session.delete_monitored_items(
        ua.DeleteMonitoredItemsParameters(SubscriptionId=own, MonitoredItemIds=[112])
    ),
    'switch items': lambda session, own: session.set_monitoring_mode(
        ua.SetMonitoringModeParameters(SubscriptionId=own)
    ),
}


@pytest.mark.parametrize('use', USES)
def test_nobody_uses_the_subscription_of_another(insecure: Served, use: str) -> None:
    async def work(bench: Bench) -> None:
        async with two(bench) as (_, second, own):
            found = await code_of(USES[use](second.uaclient.session, own))
            assert found == CODES.BadSubscriptionIdInvalid

    insecure(work)


def test_nobody_ends_or_silences_the_subscription_of_another(insecure: Served) -> None:
    async def work(bench: Bench) -> None:
        async with two(bench) as (first, second, own):
            invalid = [ua.StatusCode(CODES.BadSubscriptionIdInvalid)]
            assert await second.uaclient.session.delete_subscriptions([own]) == invalid
            params = ua.SetPublishingModeParameters(False, [own])
            assert await second.uaclient.session.set_publishing_mode(params) == invalid
            params = ua.SetPublishingModeParameters(True, [own])
            assert await first.uaclient.session.set_publishing_mode(params) == [ua.StatusCode()]

    insecure(work)


async def transfer(client: asyncua.Client, own: int) -> ua.TransferResult:
    params = ua.TransferSubscriptionsParameters([own], True)
    (result,) = await client.uaclient.session.transfer_subscriptions(params)
    return result


def test_a_subscription_is_taken_over_by_its_own_user_alone(insecure: Served) -> None:
    async def work(bench: Bench) -> None:
        async with two(bench) as (_, other, own):
            found = await transfer(other, own)
            assert found.StatusCode.value == CODES.BadUserAccessDenied
        async with two(bench, 'mes') as (first, same, own):
            assert (await transfer(same, own)).StatusCode.is_good()
            inside = bench.server.inside.subscription_service.subscriptions[own]
            # asyncua leaves it at the connection of before, where nobody asks for news any more.
            assert inside.pub_request_callback.__self__.session.person.name == 'mes'
            assert (
                inside.pub_request_callback
                == inside.pub_result_callback.__self__.get_publish_request
            )
            deleted = await first.uaclient.session.delete_subscriptions([own])
            assert deleted[0].value == CODES.BadSubscriptionIdInvalid

    insecure(work)


def test_a_server_that_was_started_anew_gives_other_ids_than_before(insecure: Served) -> None:
    # A client that comes back asks for the subscription that it had, and would get another's.
    async def work(bench: Bench) -> None:
        async def told(*_: object) -> None:
            """Nobody listens."""

        inside = bench.server.inside
        given = set()
        for _ in range(3):  # starts of a server
            service = type(inside.subscription_service)(inside.aspace)
            params = ua.CreateSubscriptionParameters()
            made = await service.create_subscription(params, told, ua.NodeId(1))
            given.add(made.SubscriptionId)
            await service.delete_subscriptions([made.SubscriptionId])
        assert len(given) == 3

    insecure(work)


def test_news_and_acknowledgements_are_of_the_session(insecure: Served) -> None:
    async def work(bench: Bench) -> None:
        async with two(bench) as (_, _, own), bench.plain('eve') as third:
            found = await code_of(third.uaclient.session.publish([]))
            assert found == CODES.BadNoSubscription
            acks = [ua.SubscriptionAcknowledgement(own, 9999)]
            _, (result,) = _of_user(bench, 'mes').publish(acks)
            assert result.value == CODES.BadSequenceNumberUnknown
            _, (result,) = _of_user(bench, 'ann').publish(acks)
            assert result.value == CODES.BadSubscriptionIdInvalid

    insecure(work)


def _of_user(bench: Bench, name: str) -> Session:
    """Return the session of a user, as it is inside the server."""
    (found,) = (one for one in bench.server.inside.sessions if one.user.name == name)
    return found


@pytest.mark.parametrize('wanted', [0.0, 1e-9, -5.0, float('nan'), float('inf'), 1e30])
def test_no_publishing_interval_keeps_the_loop_busy_or_lives_for_ever(
    insecure: Served, wanted: float
) -> None:
    async def work(bench: Bench) -> None:
        async with bench.plain() as client:
            params = ua.CreateSubscriptionParameters(wanted, 2**32 - 1, 2**32 - 1, 0, True, 0)
            made = await client.uaclient.session.create_subscription(params, lambda _: None)
            interval = made.RevisedPublishingInterval
            shortest, longest = limits.PUBLISHING_MS
            assert shortest <= interval <= longest
            assert interval * made.RevisedMaxKeepAliveCount <= limits.KEEP_ALIVE_MS
            assert interval * made.RevisedLifetimeCount <= limits.LIFETIME_MS
            assert made.RevisedLifetimeCount >= 3 * made.RevisedMaxKeepAliveCount

    insecure(work)


def test_there_are_not_too_many_subscriptions_and_watched_nodes(
    insecure: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(limits, 'SUBSCRIPTIONS_OF_SESSION', 2)
    monkeypatch.setattr(limits, 'ITEMS_OF_SESSION', 3)

    async def work(bench: Bench) -> None:
        async with bench.plain() as client:
            subscription, _ = await watching(bench, client)
            await client.create_subscription(500, Heard())
            made = client.create_subscription(500, Heard())
            assert await code_of(made) == CODES.BadTooManySubscriptions
            node = client.get_node(bench.variable.nodeid)
            more = subscription.subscribe_data_change([node] * 3)
            assert await code_of(more) == CODES.BadTooManyMonitoredItems
            monkeypatch.setattr(limits, 'ITEMS_OF_SESSION', 1000)
            same = subscription.subscribe_data_change([node] * limits.SAME)
            assert await code_of(same) == CODES.BadTooManyOperations

    insecure(work)


def test_queues_of_watched_nodes_end_also_when_they_are_changed(insecure: Served) -> None:
    async def work(bench: Bench) -> None:
        async with two(bench) as (first, _, own):
            inside = bench.server.inside.subscription_service.subscriptions[own]
            ((number, item),) = inside.monitored_item_srv._monitored_items.items()
            assert item.queue_size == limits.DATA_QUEUES[0]
            for wanted in (0, 2**32 - 1):
                one = ua.MonitoredItemModifyRequest(
                    number, ua.MonitoringParameters(QueueSize=wanted, Filter=None)
                )
                unknown = ua.MonitoredItemModifyRequest(9999, ua.MonitoringParameters())
                params = ua.ModifyMonitoredItemsParameters(
                    SubscriptionId=own, ItemsToModify=[unknown, one]
                )
                bad, good = await first.uaclient.session.modify_monitored_items(params)
                assert bad.StatusCode.value == CODES.BadMonitoredItemIdInvalid
                assert good.StatusCode.is_good()
                assert 0 < item.queue_size <= limits.DATA_QUEUES[1]

    insecure(work)


def test_a_filter_fits_its_node_and_ends() -> None:
    def condition(*operands: int) -> ua.EventFilter:
        elements = [
            ua.ContentFilterElement(ua.FilterOperator.Not, [ua.ElementOperand(one)])
            for one in operands
        ]
        return ua.EventFilter([], ua.ContentFilter(elements))

    data, events = ua.DataChangeFilter(), ua.EventFilter()
    assert refused_filter(False, None, is_required=False) is None
    assert refused_filter(False, data, is_required=False) is None
    assert refused_filter(True, events, is_required=True) is None
    assert refused_filter(True, condition(1, 2), is_required=True) == CODES.BadEventFilterInvalid
    for is_event, found in (
        (False, events), (True, data), (True, None), (True, condition(0)), (True, condition(1, 0)),
        (True, condition(1, 1)), (True, ua.EventFilter([ua.SimpleAttributeOperand()] * 300)),
    ):  # fmt: skip
        assert refused_filter(is_event, found, is_required=is_event) is not None


# --- requests -----------------------------------------------------------------------------------


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
            found = await code_of(client.uaclient.register_server2(params))
            assert found == CODES.BadServiceUnsupported
            assert 'urn:evil' not in bench.server.inside._known_servers

    secure(work)


@asynccontextmanager
async def channel(client: asyncua.Client) -> AsyncIterator[None]:
    """Open a connection without a session."""
    await client.connect_socket()
    try:
        await client.send_hello()
        await client.open_secure_channel()
        yield
    finally:
        client.disconnect_socket()


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


# --- sessions -----------------------------------------------------------------------------------


def test_a_connection_has_one_session_and_none_stays_behind(insecure: Served) -> None:
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
            names = [one.user.name for one in bench.server.inside.sessions]
            assert names == ['mes', 'ann']

    insecure(work)


def test_large_requests_are_answered_whole_and_let_others_have_their_turn(
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
                found = await session.browse(wanted)
                done.append('large')
                assert len(found) == 60
                assert len({len(one.References) for one in found}) == 1

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
            for one in (first, second):
                assert isinstance(one.auth_token.Identifier, bytes)
                assert len(one.auth_token.Identifier) == 32
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


def test_a_session_goes_on_at_another_connection_and_not_at_both(insecure: Served) -> None:
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
            found = await code_of(go_on(bench, former, 'ann'))
            assert found == CODES.BadIdentityChangeNotSupported
            node = former.get_node(bench.variable.nodeid)
            assert await node.read_value() == 1

    insecure(work)


# --- connections --------------------------------------------------------------------------------

HELLO = struct.pack('<3sc6I', b'HEL', b'F', 32, 0, 65535, 65535, 0, 0) + b'\xff\xff\xff\xff'
HELLO = HELLO[:4] + struct.pack('<I', len(HELLO)) + HELLO[8:]


async def sent(bench: Bench, *parts: bytes) -> bytes:
    """Send bytes; returns what comes until the server closes the connection."""
    reader, writer = await asyncio.open_connection('127.0.0.1', bench.server.bserver.port)
    try:
        for part in parts:
            writer.write(part)
        return await asyncio.wait_for(reader.read(), SOON_S)
    except ConnectionError:
        return b''
    finally:
        writer.close()


@pytest.mark.parametrize(
    'parts',
    [
        (b'HELF' + struct.pack('<I', 2**31), b'x' * 1000),
        (HELLO, b'OPNF' + struct.pack('<II', 2**31, 0), b'x' * 1000),
        (HELLO, b'MSGF' + struct.pack('<I', 4)),
        (HELLO, HELLO),
        (HELLO[:12] + struct.pack('<II', 1, 1) + HELLO[20:],),
        (HELLO, b'OPNF' + struct.pack('<III', 100, 0, 2**31 - 1) + b'x' * 88),
        (HELLO, b'MSGF' + struct.pack('<IIII', 24, 0, 77, 1) + b'x' * 4),
        (HELLO, b'XYZF' + struct.pack('<I', 20) + b'x' * 12),
        (b'GET / HTTP/1.1\r\n\r\n',),
        (b'OPNF' + struct.pack('<III', 32, 0, 0) + b'x' * 20,),
    ],
)
def test_what_cannot_be_read_ends_its_connection(secure: Served, parts: tuple[bytes, ...]) -> None:
    async def work(bench: Bench) -> None:
        await sent(bench, *parts)
        await becomes(lambda: not bench.server.bserver.clients)

    secure(work)


def test_a_long_message_needs_a_login_first(secure: Served) -> None:
    async def work(bench: Bench) -> None:
        client = bench.plain()
        async with channel(client):
            long = ua.GetEndpointsParameters(EndpointUrl='x' * 300_000)
            with pytest.raises((ua.UaError, ConnectionError, asyncio.TimeoutError)):
                await client.uaclient.get_endpoints(long)

    secure(work)


def test_many_connections_without_a_login_keep_nobody_out(
    secure: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(limits, 'PENDING', 3)

    async def work(bench: Bench) -> None:
        port = bench.server.bserver.port
        held = [await asyncio.open_connection('127.0.0.1', port) for _ in range(10)]
        await becomes(lambda: len(bench.server.bserver.clients) == 3)
        (first, *_) = await bench.plain().connect_and_get_server_endpoints()
        assert first.Server.ApplicationUri == bench.security.own.uri
        for _, writer in held:
            writer.close()

    secure(work)


def test_answers_that_nobody_reads_do_not_pile_up(
    insecure: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(limits, 'UNREAD_BYTES', 100_000)

    async def work(bench: Bench) -> None:
        async with bench.plain() as client:
            client.uaclient.protocol.transport.pause_reading()
            browse = ua.BrowseDescription(ua.NodeId(ua.ObjectIds.Server))
            params = ua.BrowseParameters(NodesToBrowse=[browse] * limits.BROWSED)
            asked = [
                asyncio.ensure_future(client.uaclient.session.browse(params)) for _ in range(60)
            ]
            await becomes(lambda: not bench.server.bserver.clients)
            client.uaclient.protocol.transport.abort()  # or it would wait for an answer
            for one in asked:
                one.cancel()
            await asyncio.gather(*asked, return_exceptions=True)

    insecure(work)


# --- asyncua itself -----------------------------------------------------------------------------


@pytest.mark.parametrize('found', ['2.0.9', '2.2.0', '3.0'])
def test_another_asyncua_is_refused(monkeypatch: pytest.MonkeyPatch, found: str) -> None:
    check_version()
    monkeypatch.setattr(asyncua_version, 'version', lambda _: found)
    with pytest.raises(OpcUaUnusable, match=f'2.1.x is needed, and {found} is installed'):
        check_version()
