"""What clients may ask of conditions, without a client."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace
from typing import Any

import pytest
from asyncua import ua
from fakes.statuses import hold, status

from bt_orchestrator.extensions.opcua.mes.alarms import alarms_of
from bt_orchestrator.extensions.opcua.server.calls import Caller, calling
from bt_orchestrator.extensions.opcua.server.condition_methods import (
    REFRESH,
    REFRESH_2,
    ConditionMethods,
)
from bt_orchestrator.extensions.opcua.server.conditions import Place, Standing
from bt_orchestrator.model.by import Role
from bt_orchestrator.model.stop_reason import StopReason
from bt_orchestrator.ports.doors.tickets import Outcome

ACKNOWLEDGE = ua.NodeId(ua.ObjectIds.AcknowledgeableConditionType_Acknowledge)
ADD_COMMENT = ua.NodeId(ua.ObjectIds.ConditionType_AddComment)
ENABLE = ua.NodeId(ua.ObjectIds.ConditionType_Enable)
HERE = ua.NodeId('Conditions/Hold-3', 4)
EMERGENCY = ua.NodeId('Conditions/Emergency', 4)


class Scene:
    """Two conditions, a node that notes what it is asked, and a client's calls."""

    def __init__(self, *, accepts: bool = True) -> None:
        self.asked: list[tuple[str, Any, str]] = []
        self.refreshed: list[Any] = []
        self._accepts = accepts
        cell = status(holds=[hold('3')], stop_reason=StopReason.EMERGENCY)
        self.all = {key: Standing(alarm, 1.0, 1.0) for key, alarm in alarms_of(cell).items()}
        self.service: Any = SimpleNamespace(call=self._ordinary)
        space: Any = SimpleNamespace(
            server=SimpleNamespace(iserver=SimpleNamespace(method_service=self.service)),
            notices=self,
        )
        place = Place(ua.NodeId('CellConditionType', 4), 4, ua.NodeId('cell', 4), 'cell')
        conditions: Any = self
        calls: Any = self
        ConditionMethods(conditions, calls, space, place).install()

    async def _ordinary(self, methods: list[Any]) -> list[Any]:
        result = ua.CallMethodResult()
        result.StatusCode = ua.StatusCode(ua.StatusCodes.BadNothingToDo)
        return [result for _ in methods]

    async def ask(self, request: Any, arguments: Any, reason: str) -> Outcome:
        """Stand in for the node."""
        self.asked.append((request.name, arguments, reason))
        return Outcome(self._accepts, 'said')

    def standing(self, key: str) -> Standing | None:
        """As `Conditions`."""
        return self.all.get(key)

    def put(self, standing: Standing) -> None:
        """As `Conditions`."""
        self.all[standing.alarm.key] = standing

    def events(self) -> list[str]:
        """As `Conditions`."""
        return list(self.all)

    def is_of(self, standing: Standing, event: bytes) -> bool:
        """As `Conditions`."""
        return event == b'known'

    def monitors(self, subscription: int, session: str) -> list[int] | None:
        """As `Notices`."""
        return [5] if (subscription, session) == (1, 'own') else None

    def tell_one(self, several: Any, subscription: int, item: int | None) -> None:
        """As `Notices`."""
        self.refreshed.append((several[1:-1], subscription, item))

    def call(
        self,
        node: ua.NodeId,
        method: ua.NodeId,
        *given: Any,
        role: Role = Role.OPERATE,
        session: str = 'own',
    ) -> str:
        """Call a method, and return the name of its status."""
        request = ua.CallMethodRequest(node, method, [ua.Variant(value) for value in given])
        with calling(Caller('Ann', role, 'a client', session)):
            [result] = asyncio.run(self.service.call([request]))
        return str(result.StatusCode.name)


def text(words: str) -> ua.LocalizedText:
    return ua.LocalizedText(words)


@pytest.mark.parametrize(
    ('role', 'expected'),
    [
        (Role.VIEW, 'BadUserAccessDenied'),
        (Role.MES, 'BadUserAccessDenied'),
        (Role.OPERATE, 'Good'),
        (Role.ENGINEER, 'Good'),
    ],
)
@pytest.mark.parametrize('node', [HERE, EMERGENCY])
def test_operators_acknowledge(role: Role, expected: str, node: ua.NodeId) -> None:
    scene = Scene()
    assert scene.call(node, ACKNOWLEDGE, b'known', text('seen'), role=role) == expected
    is_hold = node is HERE and expected == 'Good'
    assert scene.asked == ([('hold.acknowledge', {'hold': '3'}, 'seen')] if is_hold else [])


def test_server_keeps_acknowledgement_unknown_to_node() -> None:
    scene = Scene()
    assert scene.call(EMERGENCY, ACKNOWLEDGE, b'known', text('seen')) == 'Good'
    assert scene.all['Emergency'].is_acknowledged
    again = scene.call(EMERGENCY, ACKNOWLEDGE, b'known', text('seen'))
    assert again == 'BadConditionBranchAlreadyAcked'


def test_what_the_node_refuses_is_refused() -> None:
    scene = Scene(accepts=False)
    assert scene.call(HERE, ADD_COMMENT, b'known', text('hm')) == 'BadInvalidState'


@pytest.mark.parametrize(
    ('node', 'method', 'given', 'expected'),
    [
        (HERE, ENABLE, (), 'BadMethodInvalid'),
        (HERE, ACKNOWLEDGE, (b'known',), 'BadArgumentsMissing'),
        (HERE, ACKNOWLEDGE, (b'known', text('a'), 1), 'BadTooManyArguments'),
        (HERE, ACKNOWLEDGE, ('known', text('a')), 'BadInvalidArgument'),
        (HERE, ACKNOWLEDGE, (b'known', 'a'), 'BadInvalidArgument'),
        (HERE, ACKNOWLEDGE, (b'known', text('a' * 2001)), 'BadInvalidArgument'),
        (HERE, ADD_COMMENT, (b'known', text(' ')), 'BadInvalidArgument'),
        (HERE, ACKNOWLEDGE, (b'other', text('a')), 'BadEventIdUnknown'),
        (
            ua.NodeId('Conditions/Hold-9', 4),
            ACKNOWLEDGE,
            (b'known', text('a')),
            'BadNodeIdUnknown',
        ),
        (ua.NodeId('Conditions/Hold-3', 2), ACKNOWLEDGE, (), 'BadNothingToDo'),
        (ua.NodeId(9), REFRESH, (7,), 'BadSubscriptionIdInvalid'),
        (ua.NodeId(9), REFRESH, (), 'BadInvalidArgument'),
        (ua.NodeId(9), REFRESH, ('1',), 'BadInvalidArgument'),
        (ua.NodeId(9), REFRESH_2, (1, 6), 'BadMonitoredItemIdInvalid'),
    ],
)
def test_what_makes_no_sense_has_a_status(
    node: ua.NodeId, method: ua.NodeId, given: tuple[Any, ...], expected: str
) -> None:
    scene = Scene()
    assert scene.call(node, method, *given) == expected
    assert scene.asked == scene.refreshed == []


def test_refresh_reaches_one_subscription_or_monitored_item() -> None:
    scene = Scene()
    assert scene.call(ua.NodeId(9), REFRESH, 1, role=Role.VIEW) == 'Good'
    assert scene.call(ua.NodeId(9), REFRESH_2, 1, 5, role=Role.VIEW) == 'Good'
    other = scene.call(ua.NodeId(9), REFRESH, 1, session='another')
    assert other == 'BadSubscriptionIdInvalid'
    both = ['Emergency', 'Hold-3']
    assert scene.refreshed == [(both, 1, None), (both, 1, 5)]
