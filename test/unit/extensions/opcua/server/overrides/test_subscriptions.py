"""Subscriptions. Each test is of an override of asyncua, and fails without it."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Any

import asyncua
import pytest
from asyncua import ua
from fakes.guarded import Bench, Served, code_of
from fakes.opcua_clients import Heard, two, watching

from bt_orchestrator.extensions.opcua.server.overrides import limits
from bt_orchestrator.extensions.opcua.server.overrides.session import Session
from bt_orchestrator.extensions.opcua.server.overrides.subscriptions import refused_filter

CODES = ua.StatusCodes


def test_republish_of_what_is_not_there_says_so(insecure: Served) -> None:
    async def work(bench: Bench) -> None:
        async with two(bench) as (first, _, own):
            session = first.uaclient.session
            assert await code_of(session.republish(own, 999)) == CODES.BadMessageNotAvailable
            assert await code_of(session.republish(12345, 1)) == CODES.BadSubscriptionIdInvalid

    insecure(work)


def test_republish_repeats_unacknowledged_result_on_every_request(
    insecure: Served,
) -> None:
    async def work(bench: Bench) -> None:
        async with two(bench) as (first, _, own):
            inside = bench.server.inside.subscription_service.subscriptions[own]
            inside._not_acknowledged_results[77] = ua.PublishResult()
            inside._not_acknowledged_results[77].NotificationMessage.SequenceNumber = 77
            for _ in range(2):
                message = await first.uaclient.session.republish(own, 77)
                assert message.SequenceNumber == 77

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
            code = await code_of(USES[use](second.uaclient.session, own))
            assert code == CODES.BadSubscriptionIdInvalid

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


def test_only_owner_takes_over_subscription(insecure: Served) -> None:
    async def work(bench: Bench) -> None:
        async with two(bench) as (_, other, own):
            result = await transfer(other, own)
            assert result.StatusCode.value == CODES.BadUserAccessDenied
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


def test_restarted_server_gives_new_subscription_ids(insecure: Served) -> None:
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
            code = await code_of(third.uaclient.session.publish([]))
            assert code == CODES.BadNoSubscription
            acks = [ua.SubscriptionAcknowledgement(own, 9999)]
            _, (result,) = _of_user(bench, 'mes').publish(acks)
            assert result.value == CODES.BadSequenceNumberUnknown
            _, (result,) = _of_user(bench, 'ann').publish(acks)
            assert result.value == CODES.BadSubscriptionIdInvalid

    insecure(work)


def _of_user(bench: Bench, name: str) -> Session:
    """Return the session of a user, as it is inside the server."""
    (session,) = (entry for entry in bench.server.inside.sessions if entry.user.name == name)
    return session


@pytest.mark.parametrize('wanted', [0.0, 1e-9, -5.0, float('nan'), float('inf'), 1e30])
def test_publishing_interval_and_lifetime_are_limited(insecure: Served, wanted: float) -> None:
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


def test_subscriptions_and_monitored_items_are_limited(
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


def test_monitored_item_queues_stay_limited_when_modified(insecure: Served) -> None:
    async def work(bench: Bench) -> None:
        async with two(bench) as (first, _, own):
            inside = bench.server.inside.subscription_service.subscriptions[own]
            ((number, item),) = inside.monitored_item_srv._monitored_items.items()
            assert item.queue_size == limits.DATA_QUEUES[0]
            for wanted in (0, 2**32 - 1):
                request = ua.MonitoredItemModifyRequest(
                    number, ua.MonitoringParameters(QueueSize=wanted, Filter=None)
                )
                unknown = ua.MonitoredItemModifyRequest(9999, ua.MonitoringParameters())
                params = ua.ModifyMonitoredItemsParameters(
                    SubscriptionId=own, ItemsToModify=[unknown, request]
                )
                bad, good = await first.uaclient.session.modify_monitored_items(params)
                assert bad.StatusCode.value == CODES.BadMonitoredItemIdInvalid
                assert good.StatusCode.is_good()
                assert 0 < item.queue_size <= limits.DATA_QUEUES[1]

    insecure(work)


def test_a_filter_fits_its_node_and_ends() -> None:
    def condition(*operands: int) -> ua.EventFilter:
        elements = [
            ua.ContentFilterElement(ua.FilterOperator.Not, [ua.ElementOperand(operand)])
            for operand in operands
        ]
        return ua.EventFilter([], ua.ContentFilter(elements))

    data, events = ua.DataChangeFilter(), ua.EventFilter()
    assert refused_filter(False, None, is_required=False) is None
    assert refused_filter(False, data, is_required=False) is None
    assert refused_filter(True, events, is_required=True) is None
    assert refused_filter(True, condition(1, 2), is_required=True) == CODES.BadEventFilterInvalid
    for is_event, wrong_filter in (
        (False, events), (True, data), (True, None), (True, condition(0)), (True, condition(1, 0)),
        (True, condition(1, 1)), (True, ua.EventFilter([ua.SimpleAttributeOperand()] * 300)),
    ):  # fmt: skip
        assert refused_filter(is_event, wrong_filter, is_required=is_event) is not None
