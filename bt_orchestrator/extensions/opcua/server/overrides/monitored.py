"""Filters and queues of watched nodes.

asyncua believes that a filter fits its node. With one that does not, every write of that node
fails in its callback; and the elements of a condition may refer to each other for ever.
"""

from __future__ import annotations

from typing import Any

from asyncua import ua

from bt_orchestrator.extensions.opcua.server.overrides import limits


def refused_filter(is_event: bool, found: Any, *, is_required: bool) -> int | None:
    """Return the status code of a filter that cannot be; None: it can.

    :param is_required: there has to be one
    """
    if not found:  # one that is empty, on the wire
        return ua.StatusCodes.BadEventFilterInvalid if is_required else None
    if not is_event:
        fits = isinstance(found, ua.DataChangeFilter)
        return None if fits else ua.StatusCodes.BadMonitoredItemFilterUnsupported
    if not isinstance(found, ua.EventFilter):
        return ua.StatusCodes.BadEventFilterInvalid
    if len(found.SelectClauses or ()) > limits.SELECTED or not _ends(found.WhereClause):
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
