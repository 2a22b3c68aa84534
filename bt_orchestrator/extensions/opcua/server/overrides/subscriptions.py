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

from bt_orchestrator.extensions.opcua.server.callers import CALLER
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
        return {key: one for key, one in self.subscriptions.items() if one.session_id == session}

    def get(self, subscription: int, session: ua.NodeId) -> InternalSubscription:
        """Return one of a session.

        :raises ServiceError: BadSubscriptionIdInvalid: it has none with this id
        """
        found = self.subscriptions.get(subscription)
        if found is None or found.session_id != session:
            raise ServiceError(ua.StatusCodes.BadSubscriptionIdInvalid)
        return found


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
