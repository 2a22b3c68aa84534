"""Filters of events, where asyncua's are not as OPC UA says.

`OfType` there asks for exactly one type, so that a client that wants all alarms gets none of ours;
and a filter with a field that an event does not have writes an error for each such event.
"""

from __future__ import annotations

from typing import Any

from asyncua import ua
from asyncua.server import monitored_item_service
from asyncua.server.address_space import AddressSpace

_SUBTYPE = ua.NodeId(ua.ObjectIds.HasSubtype)
_NULL_IS_FALSE = (
    ua.FilterOperator.GreaterThan,
    ua.FilterOperator.LessThan,
    ua.FilterOperator.GreaterThanOrEqual,
    ua.FilterOperator.LessThanOrEqual,
    ua.FilterOperator.Between,
)

Original = monitored_item_service.WhereClauseEvaluator


class Evaluator(Original):  # type: ignore[misc, valid-type]
    """Decides whether an event passes a filter."""

    def _eval_el(self, index: int, event: Any) -> Any:
        element = self.elements[index]
        operands = element.FilterOperands
        if element.FilterOperator is ua.FilterOperator.OfType:
            return is_of_type(self._aspace, event.EventType, self._eval_op(operands[0], event))
        if element.FilterOperator in _NULL_IS_FALSE and any(
            self._eval_op(one, event) is None for one in operands
        ):
            return False
        return super()._eval_el(index, event)

    def _eval_op(self, operand: Any, event: Any) -> Any:
        if isinstance(operand, ua.SimpleAttributeOperand) and operand.BrowsePath:
            path = '/'.join(one.Name or '' for one in operand.BrowsePath)
            return getattr(event, path, None)
        return super()._eval_op(operand, event)


def install() -> None:
    """Have all subscriptions filter like this."""
    monitored_item_service.WhereClauseEvaluator = Evaluator


def is_of_type(space: AddressSpace, type_id: ua.NodeId | None, wanted: ua.NodeId) -> bool:
    """Tell whether a type is another one, or a subtype of it."""
    while type_id is not None:
        if type_id == wanted:
            return True
        type_id = next(
            (
                one.NodeId
                for one in (space[type_id].references if type_id in space else ())
                if one.ReferenceTypeId == _SUBTYPE and not one.IsForward
            ),
            None,
        )
    return False
