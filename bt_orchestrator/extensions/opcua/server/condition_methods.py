"""The requests of clients about conditions: refresh, acknowledge, comment.

Our conditions have no nodes, so calls of their methods are answered here and not by asyncua, which
knows methods of nodes only.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator, Mapping, Sequence
from typing import Protocol

from asyncua import ua

from bt_orchestrator.extensions.opcua.server.calls import (
    CALLER,
    Argument,
    Calls,
    with_status,
    wrong,
)
from bt_orchestrator.extensions.opcua.server.conditions import Place, Remark, Standing
from bt_orchestrator.extensions.opcua.server.notices import SERVER, Told, id_of
from bt_orchestrator.extensions.opcua.server.space import Space
from bt_orchestrator.model.limits import REASON
from bt_orchestrator.model.requests import ACKNOWLEDGE, COMMENT, Request
from bt_orchestrator.model.texts import text_fault

log = logging.getLogger(__name__)

_REQUESTS: Mapping[ua.NodeId, Request] = {
    ua.NodeId(ua.ObjectIds.AcknowledgeableConditionType_Acknowledge): ACKNOWLEDGE,
    ua.NodeId(ua.ObjectIds.ConditionType_AddComment): COMMENT,
}
_ARGUMENTS = (
    Argument('EventId', ua.VariantType.ByteString, ''),
    Argument('Comment', ua.VariantType.LocalizedText, ''),
)
"""Of both methods."""

REFRESH = ua.NodeId(ua.ObjectIds.ConditionType_ConditionRefresh)
REFRESH_2 = ua.NodeId(ua.ObjectIds.ConditionType_ConditionRefresh2)


class Conditions(Protocol):
    """The knowledge of the conditions."""

    def standing(self, key: str) -> Standing | None:
        """Return a condition."""

    def put(self, standing: Standing) -> None:
        """Show a condition from now on."""

    def events(self) -> Iterator[Told]:
        """Yield all conditions."""

    def is_of(self, standing: Standing, event: bytes) -> bool:
        """Tell whether an EventId is that of the present state of a condition."""


class ConditionMethods:
    """Answers the methods of conditions."""

    def __init__(self, conditions: Conditions, calls: Calls, space: Space, place: Place) -> None:
        self._conditions = conditions
        self._calls = calls
        self._space = space
        self._place = place
        self._refreshes = 0

    def install(self) -> None:
        """Take the calls for conditions out of those that asyncua answers."""
        service = self._space.server.iserver.method_service
        ordinary = service.call

        async def call(methods: Sequence[ua.CallMethodRequest]) -> list[ua.CallMethodResult]:
            results: list[ua.CallMethodResult] = []
            for method in methods:
                own = await self._own(method)
                results += await ordinary([method]) if own is None else [own]
            return results

        service.call = call

    async def _own(self, method: ua.CallMethodRequest) -> ua.CallMethodResult | None:
        key = self._place.key(method.ObjectId)
        if key is not None:
            return await self._to_condition(key, method)
        if method.MethodId in (REFRESH, REFRESH_2):
            return self._refresh(method.InputArguments or [])
        return None

    # --- of one condition -------------------------------------------------------------------

    async def _to_condition(self, key: str, method: ua.CallMethodRequest) -> ua.CallMethodResult:
        codes = ua.StatusCodes
        request = _REQUESTS.get(method.MethodId)
        if request is None:
            return with_status(codes.BadMethodInvalid)
        misfit = wrong(_ARGUMENTS, method.InputArguments or [])
        if misfit is not None:
            return misfit
        event, comment = (argument.Value for argument in method.InputArguments)
        words = '' if comment is None else (comment.Text or '').strip()
        if len(words) > REASON or text_fault(words) is not None:
            return with_status(codes.BadInvalidArgument)
        if request is COMMENT and not words:
            return with_status(codes.BadInvalidArgument)
        caller = CALLER.get()
        if caller.role not in request.roles:
            return with_status(codes.BadUserAccessDenied)
        standing = self._conditions.standing(key)
        if standing is None:
            return with_status(codes.BadNodeIdUnknown)
        if not self._conditions.is_of(standing, event):
            return with_status(codes.BadEventIdUnknown)
        if request is ACKNOWLEDGE and standing.is_acknowledged:
            return with_status(codes.BadConditionBranchAlreadyAcked)
        return await self._remark(request, standing, Remark(caller.name, words, time.time()))

    async def _remark(
        self, request: Request, standing: Standing, remark: Remark
    ) -> ua.CallMethodResult:
        """Have the node record it, which informs all followers; it knows holds only."""
        if not standing.alarm.hold:
            log.info('%s: %s %s: %s', remark.who, request.word, standing.alarm.key, remark.words)
            self._conditions.put(standing.with_remark(request.word, remark))
            return with_status(ua.StatusCodes.Good)
        try:
            outcome = await self._calls.ask(request, {'hold': standing.alarm.hold}, remark.words)
        except ua.UaStatusCodeError as error:
            return with_status(error.code)
        codes = ua.StatusCodes
        return with_status(codes.Good if outcome.accepted else codes.BadInvalidState)

    # --- of all -----------------------------------------------------------------------------

    def _refresh(self, given: list[ua.Variant]) -> ua.CallMethodResult:
        """Tell one subscription, or one of its monitors, of every condition again."""
        numbers = [argument.Value for argument in given]
        if not 1 <= len(numbers) <= 2 or not all(type(number) is int for number in numbers):
            return with_status(ua.StatusCodes.BadInvalidArgument)
        subscription, item = numbers[0], numbers[1] if len(numbers) == 2 else None
        monitors = self._space.notices.monitors(subscription, CALLER.get().session)
        if monitors is None:
            return with_status(ua.StatusCodes.BadSubscriptionIdInvalid)
        if item is not None and item not in monitors:
            return with_status(ua.StatusCodes.BadMonitoredItemIdInvalid)
        self._refreshes += 1
        now = time.time()
        begin, end = (
            Told(
                ua.NodeId(kind), id_of('refresh', now, self._refreshes, kind), SERVER, 'Server',
                now, words,
            )
            for kind, words in (
                (ua.ObjectIds.RefreshStartEventType, 'conditions follow'),
                (ua.ObjectIds.RefreshEndEventType, 'these were all conditions'),
            )
        )  # fmt: skip
        self._space.notices.tell_one([begin, *self._conditions.events(), end], subscription, item)
        return with_status(ua.StatusCodes.Good)
