"""Questions about an order as messages, and back; the desk reads its content."""

from __future__ import annotations

from typing import Any

from bt_orchestrator_interfaces import msg, srv

from bt_orchestrator.ros.types.mapping import Codec, flat, mapped
from bt_orchestrator.ros.types.status_messages import CHOICE
from bt_orchestrator.script.orders.desk import AskedOrder
from bt_orchestrator.script.orders.terms import AskedTerms

_ABSENT = Codec((), lambda _: {}, lambda _: '')


def _apart(message: Any, **others: Codec) -> dict[str, Codec]:
    terms = flat(AskedTerms, message, {'first_piece': Codec((), lambda _: {}, lambda _: None)})
    return {'terms': terms, 'recipe': CHOICE, 'text': _ABSENT, **others}


_ORDER = mapped(AskedOrder, msg.WorkOrder, _apart(msg.WorkOrder))
_CHANGE = flat(AskedOrder, srv.QueueUpdate.Request, _apart(srv.QueueUpdate.Request, order=_ABSENT))

order_message, asked_order = _ORDER.write, _ORDER.read
"""The request of `~/submit_order` has the fields of a work order, too."""
asked_change = _CHANGE.read
