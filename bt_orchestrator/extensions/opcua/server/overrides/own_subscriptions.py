"""The rights of a session over subscriptions: its own alone, and within limits."""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Callable, Iterable, Sized
from typing import TYPE_CHECKING, Any

from asyncua import ua
from asyncua.common.utils import ServiceError
from asyncua.server.internal_session import InternalSession
from asyncua.server.internal_subscription import InternalSubscription
from asyncua.server.uaprocessor import UaProcessor

from bt_orchestrator.extensions.opcua.server.overrides import limits
from bt_orchestrator.extensions.opcua.server.overrides.subscriptions import (
    refused_filter,
    revise_queue,
)

if TYPE_CHECKING:
    from bt_orchestrator.extensions.opcua.server.overrides.subscriptions import Subscriptions

log = logging.getLogger(__name__)


class OwnSubscriptions(InternalSession):
    """asyncua lets a session use the subscriptions of all others."""

    subscription_service: Subscriptions

    @property
    def _own(self) -> dict[int, InternalSubscription]:
        return self.subscription_service.of_session(self.session_id)

    def _get(self, subscription: int) -> InternalSubscription:
        return self.subscription_service.get(subscription, self.session_id)

    async def create_subscription(
        self,
        params: ua.CreateSubscriptionParameters,
        callback: Callable[..., Any],
        request_callback: Callable[..., Any] | None = None,
    ) -> ua.CreateSubscriptionResult:
        """Make one, if there are not too many."""
        if len(self._own) >= limits.SUBSCRIPTIONS_OF_SESSION:
            raise ServiceError(ua.StatusCodes.BadTooManySubscriptions)
        return await super().create_subscription(params, callback, request_callback)

    def modify_subscription(
        self, params: ua.ModifySubscriptionParameters
    ) -> ua.ModifySubscriptionResult:
        """Answer what it is like; asyncua changes nothing."""
        self._get(params.SubscriptionId)
        return super().modify_subscription(params)

    async def create_monitored_items(
        self, params: ua.CreateMonitoredItemsParameters
    ) -> list[ua.MonitoredItemCreateResult]:
        """Watch some nodes, each with a filter that fits and a queue that ends."""
        self._get(params.SubscriptionId)
        items = params.ItemsToCreate
        check_count(items, limits.NODES)
        watched = [
            item.read_value_id
            for subscription in self._own.values()
            for item in subscription.monitored_item_srv._monitored_items.values()
        ]
        if len(watched) + len(items) > limits.ITEMS_OF_SESSION:
            raise ServiceError(ua.StatusCodes.BadTooManyMonitoredItems)
        check_same([*watched, *(item.ItemToMonitor for item in items)])
        refusals = [_refusal(item) for item in items]
        params.ItemsToCreate = [
            item for item, refusal in zip(items, refusals, strict=True) if refusal is None
        ]
        made = iter(await super().create_monitored_items(params))
        return [next(made) if refusal is None else refusal for refusal in refusals]

    async def modify_monitored_items(
        self, params: ua.ModifyMonitoredItemsParameters
    ) -> list[ua.MonitoredItemModifyResult]:
        """Change some; asyncua forgets the limit of their queues here."""
        items = self._get(params.SubscriptionId).monitored_item_srv._monitored_items
        check_count(params.ItemsToModify, limits.NODES)
        results, fitting = {}, []
        for place, change in enumerate(params.ItemsToModify):
            item = items.get(change.MonitoredItemId)
            wanted = change.RequestedParameters
            if item is None or item.read_value_id is None:
                results[place] = ua.StatusCodes.BadMonitoredItemIdInvalid
                continue
            is_event = item.read_value_id.AttributeId == ua.AttributeIds.EventNotifier
            code = refused_filter(is_event, wanted.Filter, is_required=False)
            if code is not None:
                results[place] = code
                continue
            revise_queue(is_event, wanted)
            fitting.append(change)
        params.ItemsToModify = fitting
        made = iter(await super().modify_monitored_items(params))
        return [
            ua.MonitoredItemModifyResult(StatusCode=ua.StatusCode(results[place]))
            if place in results
            else next(made)
            for place in range(len(results) + len(fitting))
        ]

    async def delete_monitored_items(
        self, params: ua.DeleteMonitoredItemsParameters
    ) -> list[ua.StatusCode]:
        """Stop watching some nodes."""
        self._get(params.SubscriptionId)
        return await super().delete_monitored_items(params)

    async def set_monitoring_mode(
        self, params: ua.SetMonitoringModeParameters
    ) -> list[ua.StatusCode]:
        """Switch some items."""
        self._get(params.SubscriptionId)
        return await super().set_monitoring_mode(params)

    async def set_publishing_mode(
        self, params: ua.SetPublishingModeParameters
    ) -> list[ua.StatusCode]:
        """Switch some subscriptions."""
        own, results = self._own, []
        for number in params.SubscriptionIds:
            if number in own:
                await own[number].set_publishing_mode(params.PublishingEnabled)
            results.append(_good_if(number in own, ua.StatusCodes.BadSubscriptionIdInvalid))
        return results

    async def delete_subscriptions(self, ids: list[int]) -> list[ua.StatusCode]:
        """End some subscriptions."""
        own = self._own
        made = iter(
            await super().delete_subscriptions([number for number in ids if number in own])
        )
        invalid = ua.StatusCode(ua.StatusCodes.BadSubscriptionIdInvalid)
        return [next(made) if number in own else invalid for number in ids]

    def publish(
        self, acks: Iterable[ua.SubscriptionAcknowledgement] | None = None
    ) -> tuple[int, list[ua.StatusCode]]:
        """Acknowledge, and wait for news; asyncua says Good to a number that it does not know."""
        own, results = self._own, []
        if not own:
            raise ServiceError(ua.StatusCodes.BadNoSubscription)
        for ack in acks or ():
            subscription = own.get(ack.SubscriptionId)
            if subscription is None:
                results.append(ua.StatusCode(ua.StatusCodes.BadSubscriptionIdInvalid))
                continue
            is_known = ack.SequenceNumber in subscription._not_acknowledged_results
            subscription.publish([ack.SequenceNumber])
            results.append(_good_if(is_known, ua.StatusCodes.BadSequenceNumberUnknown))
        return len(own), results

    def republish(self, params: ua.RepublishParameters) -> ua.NotificationMessage:
        """Repeat a notification.

        asyncua answers Good and nothing for one that it does not have, and node-opcua then asks a
        thousand times a second, for ever. It also forgets one that it has repeated, although it
        was not acknowledged.
        """
        kept = self._get(params.SubscriptionId)._not_acknowledged_results
        notification = kept.get(params.RetransmitSequenceNumber)
        if notification is None:
            raise ServiceError(ua.StatusCodes.BadMessageNotAvailable)
        return notification.NotificationMessage

    async def take_over(
        self, params: ua.TransferSubscriptionsParameters, processor: UaProcessor
    ) -> list[ua.TransferResult]:
        """Take subscriptions of other sessions of the same user.

        asyncua asks for no user, and lets the former connection go on to answer for them.
        """
        if len(self._own) + len(params.SubscriptionIds) > limits.SUBSCRIPTIONS_OF_SESSION:
            raise ServiceError(ua.StatusCodes.BadTooManySubscriptions)
        return [
            await self._take_over(number, processor, params.SendInitialValues)
            for number in params.SubscriptionIds
        ]

    async def _take_over(
        self, number: int, processor: UaProcessor, with_values: bool
    ) -> ua.TransferResult:
        subscription = self.subscription_service.subscriptions.get(number)
        if subscription is None:
            return _transferred(ua.StatusCodes.BadSubscriptionIdInvalid)
        if subscription.session_id == self.session_id:
            return _transferred(ua.StatusCodes.BadNothingToDo)
        if not self.user.name or self.subscription_service.owner_of(number) != self.user.name:
            log.warning('%s may not take over a subscription of another user', self.user.name)
            return _transferred(ua.StatusCodes.BadUserAccessDenied)
        former = getattr(subscription.pub_request_callback, '__self__', None)
        if former is not None:
            former.forget(number)
        subscription.session_id = self.session_id
        subscription.pub_result_callback = processor.forward_publish_response
        subscription.pub_request_callback = processor.get_publish_request
        if with_values:
            await _tell_anew(subscription)
        result = _transferred(ua.StatusCodes.Good)
        result.AvailableSequenceNumbers = sorted(subscription._not_acknowledged_results)
        return result


def check_count(given: Sized | None, most: int) -> None:
    """Refuse a request for too many things at once.

    :raises ServiceError: BadTooManyOperations
    """
    if given is not None and len(given) > most:
        raise ServiceError(ua.StatusCodes.BadTooManyOperations)


def check_same(given: Iterable[ua.ReadValueId] | None) -> None:
    """Refuse a request for one and the same value many times.

    :raises ServiceError: BadTooManyOperations
    """
    counts = Counter((value_id.NodeId, value_id.AttributeId) for value_id in given or ())
    if counts and max(counts.values()) > limits.SAME:
        raise ServiceError(ua.StatusCodes.BadTooManyOperations)


def _refusal(item: ua.MonitoredItemCreateRequest) -> ua.MonitoredItemCreateResult | None:
    """Return why a node cannot be watched like this; None: it can."""
    is_event = item.ItemToMonitor.AttributeId == ua.AttributeIds.EventNotifier
    code = refused_filter(is_event, item.RequestedParameters.Filter, is_required=is_event)
    if code is not None:
        return ua.MonitoredItemCreateResult(StatusCode=ua.StatusCode(code))
    revise_queue(is_event, item.RequestedParameters)
    return None


def _good_if(is_good: bool, otherwise: int) -> ua.StatusCode:
    return ua.StatusCode(ua.StatusCodes.Good if is_good else otherwise)


def _transferred(code: int) -> ua.TransferResult:
    result = ua.TransferResult()
    result.StatusCode = ua.StatusCode(code)
    return result


async def _tell_anew(subscription: InternalSubscription) -> None:
    """Tell every value that is watched once more."""
    service = subscription.monitored_item_srv
    for handle, number in service._monitored_datachange.items():
        item = service._monitored_items[number]
        item.mvalue.current_dvalue = None
        if item.read_value_id is not None and item.mode != ua.MonitoringMode.Disabled:
            what = item.read_value_id
            await service.trigger_datachange(handle, what.NodeId, what.AttributeId)
