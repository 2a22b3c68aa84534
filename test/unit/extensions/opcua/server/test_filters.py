"""Filters of events, where asyncua's are not as OPC UA says."""

from __future__ import annotations

import logging
from types import SimpleNamespace
from typing import Any

import pytest
from asyncua import ua

from bt_orchestrator.extensions.opcua.server.overrides.inside import Evaluator, Original

ALARM, HOLD = ua.NodeId(1, 4), ua.NodeId(2, 4)
EVENT: Any = SimpleNamespace(EventType=HOLD, Severity=600, **{'AckedState/Id': False})


def field(path: str) -> ua.SimpleAttributeOperand:
    names = [ua.QualifiedName(name) for name in path.split('/')]
    return ua.SimpleAttributeOperand(ua.NodeId(), names, ua.AttributeIds.Value)


def value(operand: object) -> ua.LiteralOperand:
    return ua.LiteralOperand(Value=ua.Variant(operand))


def passes(operator: ua.FilterOperator, *operands: Any, with_: Any = Evaluator) -> bool:
    where = ua.ContentFilter([ua.ContentFilterElement(operator, list(operands))])
    return bool(with_(logging.getLogger('test'), space(), where).eval(EVENT))


def space() -> Any:
    """Return types, of which each names the one above."""
    above = {
        HOLD: ALARM,
        ALARM: ua.NodeId(ua.ObjectIds.AlarmConditionType),
    }
    subtype = ua.NodeId(ua.ObjectIds.HasSubtype)
    return {
        type_: SimpleNamespace(
            references=[SimpleNamespace(NodeId=parent, ReferenceTypeId=subtype, IsForward=False)]
        )
        for type_, parent in above.items()
    }


@pytest.mark.parametrize(
    ('wanted', 'expected'),
    [
        (HOLD, True),
        (ALARM, True),
        (ua.NodeId(ua.ObjectIds.AlarmConditionType), True),
        (ua.NodeId(ua.ObjectIds.AuditEventType), False),
    ],
)
def test_event_matches_own_and_base_types(wanted: ua.NodeId, expected: bool) -> None:
    assert passes(ua.FilterOperator.OfType, value(wanted)) is expected


def test_a_field_inside_another_is_compared() -> None:
    assert passes(ua.FilterOperator.Equals, field('AckedState/Id'), value(False))
    assert not passes(ua.FilterOperator.Equals, field('AckedState/Id'), value(True))


def test_missing_event_field_is_null_without_error(
    caplog: pytest.LogCaptureFixture,
) -> None:
    greater = ua.FilterOperator.GreaterThan
    assert passes(greater, field('Severity'), value(500))
    assert not passes(greater, field('Speed'), value(500))
    assert passes(ua.FilterOperator.IsNull, field('Speed'))
    assert caplog.records == []
    assert not passes(greater, field('Speed'), value(500), with_=Original)
    assert caplog.records != []
