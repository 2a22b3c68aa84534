"""Subscriptions: whose they are, how fast and how long they live."""

from __future__ import annotations

import math
import secrets
from collections.abc import Callable
from typing import Any

from asyncua import ua
from asyncua.common.utils import ServiceError
from asyncua.server.internal_subscription import InternalSubscription
from asyncua.server.subscription_service import SubscriptionService

from bt_orchestrator.extensions.opcua.server.calls import CALLER
from bt_orchestrator.extensions.opcua.server.overrides import limits

_FIRST_IDS = 2**31
"""The id before the first one is below this number: half of all ids are left to give."""


class Subscriptions(SubscriptionService):
    """asyncua lets every session use those of all others."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        # asyncua begins with the same number at every start. A client that comes back after a
        # restart would then take over what another one has just been given (OPC 10000-4,
        # CreateSubscription: the ids start from a random one).
        self._sub_id_counter = secrets.randbelow(_FIRST_IDS)
        self._owners: dict[int, str] = {}

    async def create_subscription(
        self,
        params: ua.CreateSubscriptionParameters,
        callback: Callable[..., Any],
        session_id: ua.NodeId,
        request_callback: Callable[..., Any] | None = None,
    ) -> ua.CreateSubscriptionResult:
        """Make one, at a pace that the loop can bear."""
        _revise(params)
        result = await super().create_subscription(params, callback, session_id, request_callback)
        self._owners = {key: who for key, who in self._owners.items() if key in self.subscriptions}
        caller = CALLER.get(None)
        if caller is not None:
            self._owners[result.SubscriptionId] = caller.name
        return result

    def owner_of(self, subscription: int) -> str:
        """Return the name of its user; empty: it has no user."""
        return self._owners.get(subscription, '')

    def of_session(self, session: ua.NodeId) -> dict[int, InternalSubscription]:
        """Return those of a session, by id."""
        return {
            key: subscription
            for key, subscription in self.subscriptions.items()
            if subscription.session_id == session
        }

    def get(self, subscription: int, session: ua.NodeId) -> InternalSubscription:
        """Return one of a session.

        :raises ServiceError: BadSubscriptionIdInvalid: it has none with this id
        """
        entry = self.subscriptions.get(subscription)
        if entry is None or entry.session_id != session:
            raise ServiceError(ua.StatusCodes.BadSubscriptionIdInvalid)
        return entry


def _revise(params: ua.CreateSubscriptionParameters) -> None:
    """Change what was asked for into what is possible.

    asyncua takes every publishing interval: with one of 0 a subscription would never expire, and
    with one near 0 its loop would not rest.
    """
    wanted = params.RequestedPublishingInterval
    shortest, longest = limits.PUBLISHING_MS
    interval = min(max(wanted, shortest), longest) if math.isfinite(wanted) else shortest
    most_quiet = max(1, int(limits.KEEP_ALIVE_MS / interval))
    quiet = min(params.RequestedMaxKeepAliveCount or 10, most_quiet)
    most = max(3 * quiet, int(limits.LIFETIME_MS / interval))
    params.RequestedPublishingInterval = interval
    params.RequestedMaxKeepAliveCount = quiet
    params.RequestedLifetimeCount = max(
        3 * quiet, min(params.RequestedLifetimeCount or most, most)
    )


# Filters and queues of watched nodes.
#
# asyncua believes that a filter fits its node. With one that does not, every write of that node
# fails in its callback; and the elements of a condition may refer to each other for ever.


def refused_filter(is_event: bool, filter_: Any, *, is_required: bool) -> int | None:
    """Return the status code of a filter that cannot be; None: it can.

    :param is_required: there has to be one
    """
    if not filter_:  # one that is empty, on the wire
        return ua.StatusCodes.BadEventFilterInvalid if is_required else None
    if not is_event:
        fits = isinstance(filter_, ua.DataChangeFilter)
        return None if fits else ua.StatusCodes.BadMonitoredItemFilterUnsupported
    if not isinstance(filter_, ua.EventFilter):
        return ua.StatusCodes.BadEventFilterInvalid
    if len(filter_.SelectClauses or ()) > limits.SELECTED or not _ends(filter_.WhereClause):
        return ua.StatusCodes.BadEventFilterInvalid
    return None


def revise_queue(is_event: bool, wanted: ua.MonitoringParameters) -> None:
    """Change the length that was asked for into one that is possible; 0 would be without end."""
    usual, most = limits.EVENT_QUEUES if is_event else limits.DATA_QUEUES
    wanted.QueueSize = min(wanted.QueueSize or usual, most)


def _ends(condition: ua.ContentFilter) -> bool:
    """Tell whether evaluating it ends soon: each element is used at most once, by one before."""
    elements = condition.Elements or ()
    if len(elements) > limits.CONDITIONS:
        return False
    used: set[int] = set()
    for place, element in enumerate(elements):
        for operand in element.FilterOperands or ():
            if isinstance(operand, ua.ElementOperand):
                if not place < operand.Index < len(elements) or operand.Index in used:
                    return False
                used.add(operand.Index)
    return True
