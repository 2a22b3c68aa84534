"""The part of the server that all connections share: sessions, subscriptions, methods, views."""

from __future__ import annotations

import logging
from typing import Any

from asyncua import ua
from asyncua.crypto.permission_rules import User, UserRole
from asyncua.server import monitored_item_service
from asyncua.server.address_space import AddressSpace, MethodService, ViewService
from asyncua.server.internal_server import InternalServer

from bt_orchestrator.extensions.opcua.server.overrides import limits
from bt_orchestrator.extensions.opcua.server.overrides.security import Security
from bt_orchestrator.extensions.opcua.server.overrides.session import Session
from bt_orchestrator.extensions.opcua.server.overrides.subscriptions import Subscriptions


class Inside(InternalServer):
    """The inner server, which all connections share."""

    method_service: MethodService
    view_service: Views

    def __init__(self, security: Security) -> None:
        super().__init__()
        self.security = security
        install_filters()
        self.certificate = security.own.certificate
        self.private_key = security.own.key
        # Sessions are let in by `Processor`; asyncua would ask a manager, in the loop.
        self.user_manager = None
        self.supported_tokens = (ua.UserNameIdentityToken,)
        self.method_service.stop()
        self.method_service = Methods(self.aspace)
        self.view_service = Views(self.aspace)
        self.subscription_service = self.isession.subscription_service = Subscriptions(
            self.aspace, iserver=self
        )
        self.max_connections = limits.CONNECTIONS
        self.max_pending_activation_seconds = limits.PENDING_S
        self.max_pending_messages_per_connection = limits.WAITING_MESSAGES
        self.min_session_timeout_ms, self.max_session_timeout_ms = limits.SESSION_MS
        self.max_subscriptions = limits.SUBSCRIPTIONS
        self.max_monitored_item_queue_size = limits.EVENT_QUEUES[1]
        self.max_unacked_messages_per_subscription = limits.KEPT_MESSAGES

    def create_session(
        self, name: str, user: User | None = None, external: bool = False
    ) -> Session:
        """Return a session of a client."""
        return Session(
            self,
            self.aspace,
            self.subscription_service,
            name,
            user=user or User(role=UserRole.Anonymous),
            external=external,
        )

    @property
    def sessions(self) -> list[Session]:
        """Those of clients, also such as wait for their client to come back."""
        return [
            session for session in self._external_sessions.values() if isinstance(session, Session)
        ]


# Calls of methods: a method says by its exception what was wrong.

log = logging.getLogger(__name__)


class Methods(MethodService):
    """asyncua answers every exception with BadUnexpectedError."""

    async def _run_method(self, func: Any, parent: ua.NodeId, *args: Any) -> Any:
        try:
            return await super()._run_method(func, parent, *args)
        except ua.UaStatusCodeError as error:
            return ua.StatusCode(error.code)
        except Exception:
            log.exception('defect: a method failed')
            return ua.StatusCode(ua.StatusCodes.BadInternalError)


# Browsing: which types of references are below which one is worked out once.


class Views(ViewService):
    """asyncua walks the types of references for each reference of each node.

    500 nodes with many references would hold the loop for ten seconds.
    """

    def __init__(self, aspace: AddressSpace) -> None:
        super().__init__(aspace)
        self._below: dict[ua.NodeId, frozenset[ua.NodeId]] = {}

    def _get_sub_ref(self, ref: ua.NodeId) -> frozenset[ua.NodeId]:
        subtypes = self._below.get(ref)
        if subtypes is None:
            subtypes = frozenset(super()._get_sub_ref(ref))
            if ref in self._aspace:  # clients may name any number of others
                self._below[ref] = subtypes
        return subtypes

    def forget(self) -> None:
        """Work it out anew: nodesets were loaded meanwhile."""
        self._below.clear()


# Filters of events, where asyncua's are not as OPC UA says.
#
# `OfType` there asks for exactly one type, so that a client that wants all alarms gets none of
# ours; and a filter with a field that an event does not have writes an error for each such event.

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
            self._eval_op(operand, event) is None for operand in operands
        ):
            return False
        return super()._eval_el(index, event)

    def _eval_op(self, operand: Any, event: Any) -> Any:
        if isinstance(operand, ua.SimpleAttributeOperand) and operand.BrowsePath:
            path = '/'.join(name.Name or '' for name in operand.BrowsePath)
            return getattr(event, path, None)
        return super()._eval_op(operand, event)


def install_filters() -> None:
    """Have all subscriptions filter like this."""
    monitored_item_service.WhereClauseEvaluator = Evaluator


def is_of_type(space: AddressSpace, type_id: ua.NodeId | None, wanted: ua.NodeId) -> bool:
    """Tell whether a type is another one, or a subtype of it."""
    while type_id is not None:
        if type_id == wanted:
            return True
        type_id = next(
            (
                reference.NodeId
                for reference in (space[type_id].references if type_id in space else ())
                if reference.ReferenceTypeId == _SUBTYPE and not reference.IsForward
            ),
            None,
        )
    return False
