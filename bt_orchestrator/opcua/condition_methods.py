"""What clients ask of conditions: refresh, acknowledge, comment.

Our conditions have no nodes, so calls of their methods are answered here and not by asyncua, which
knows methods of nodes only.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Awaitable, Callable, Iterator, Mapping, Sequence
from typing import Protocol

from asyncua import ua

from bt_orchestrator.model.roles import Role
from bt_orchestrator.opcua.callers import CALLER
from bt_orchestrator.opcua.conditions import Place, Remark, Standing
from bt_orchestrator.opcua.notices import SERVER, Told, id_of
from bt_orchestrator.opcua.space import Space

log = logging.getLogger(__name__)

ACKNOWLEDGE = ua.NodeId(ua.ObjectIds.AcknowledgeableConditionType_Acknowledge)
ADD_COMMENT = ua.NodeId(ua.ObjectIds.ConditionType_AddComment)
REFRESH = ua.NodeId(ua.ObjectIds.ConditionType_ConditionRefresh)
REFRESH_2 = ua.NodeId(ua.ObjectIds.ConditionType_ConditionRefresh2)

MAY = (Role.OPERATE, Role.ENGINEER)
"""Roles that may acknowledge and comment."""

LONGEST_COMMENT = 2_000

_Method = Callable[[Standing, Remark], Awaitable[ua.CallMethodResult]]


class Conditions(Protocol):
    """What is known of the conditions."""

    def standing(self, key: str) -> Standing | None:
        """Return a condition."""

    def put(self, standing: Standing) -> None:
        """Show a condition from now on."""

    def events(self) -> Iterator[Told]:
        """Yield all conditions."""

    def is_of(self, standing: Standing, event: bytes) -> bool:
        """Tell whether an EventId is that of a condition as it is now."""


class ConditionMethods:
    """Answers the methods of conditions."""

    def __init__(self, conditions: Conditions, space: Space, place: Place) -> None:
        self._conditions = conditions
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
        do = self._methods.get(method.MethodId)
        if do is None:
            return _result(ua.StatusCodes.BadMethodInvalid)
        given = [one.Value for one in method.InputArguments or []]
        if len(given) != 2:
            few = len(given) < 2
            codes = ua.StatusCodes
            return _result(codes.BadArgumentsMissing if few else codes.BadTooManyArguments)
        event, comment = given
        words = (comment.Text or '') if isinstance(comment, ua.LocalizedText) else None
        if not isinstance(event, bytes) or words is None or len(words) > LONGEST_COMMENT:
            return _result(ua.StatusCodes.BadInvalidArgument)
        caller = CALLER.get()
        if caller.role not in MAY:
            return _result(ua.StatusCodes.BadUserAccessDenied)
        standing = self._conditions.standing(key)
        if standing is None:
            return _result(ua.StatusCodes.BadNodeIdUnknown)
        if not self._conditions.is_of(standing, event):
            return _result(ua.StatusCodes.BadEventIdUnknown)
        return await do(standing, Remark(caller.name, words, time.time()))

    @property
    def _methods(self) -> Mapping[ua.NodeId, _Method]:
        return {ACKNOWLEDGE: self._acknowledge, ADD_COMMENT: self._comment}

    async def _acknowledge(self, standing: Standing, remark: Remark) -> ua.CallMethodResult:
        if standing.is_acknowledged:
            return _result(ua.StatusCodes.BadConditionBranchAlreadyAcked)
        log.info('%s acknowledged %s: %s', remark.who, standing.alarm.key, remark.words)
        self._conditions.put(standing.acknowledged(remark))
        return _result(ua.StatusCodes.Good)

    async def _comment(self, standing: Standing, remark: Remark) -> ua.CallMethodResult:
        log.info('%s said of %s: %s', remark.who, standing.alarm.key, remark.words)
        self._conditions.put(standing.commented(remark))
        return _result(ua.StatusCodes.Good)

    # --- of all -----------------------------------------------------------------------------

    def _refresh(self, given: list[ua.Variant]) -> ua.CallMethodResult:
        """Tell one subscription, or one of its monitors, of every condition again."""
        numbers = [one.Value for one in given]
        if not 1 <= len(numbers) <= 2 or not all(type(one) is int for one in numbers):
            return _result(ua.StatusCodes.BadInvalidArgument)
        subscription, item = numbers[0], numbers[1] if len(numbers) == 2 else None
        monitors = self._space.notices.monitors(subscription)
        if monitors is None:
            return _result(ua.StatusCodes.BadSubscriptionIdInvalid)
        if item is not None and item not in monitors:
            return _result(ua.StatusCodes.BadMonitoredItemIdInvalid)
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
        return _result(ua.StatusCodes.Good)


def _result(code: int) -> ua.CallMethodResult:
    result = ua.CallMethodResult()
    result.StatusCode = ua.StatusCode(code)
    return result
