"""The part of the server that all connections share: sessions, subscriptions, limits."""

from __future__ import annotations

from asyncua import ua
from asyncua.crypto.permission_rules import User, UserRole
from asyncua.server.address_space import MethodService
from asyncua.server.internal_server import InternalServer

from bt_orchestrator.extensions.opcua.server.overrides import filters, limits
from bt_orchestrator.extensions.opcua.server.overrides.methods import Methods
from bt_orchestrator.extensions.opcua.server.overrides.security import Security
from bt_orchestrator.extensions.opcua.server.overrides.session import Session
from bt_orchestrator.extensions.opcua.server.overrides.subscriptions import Subscriptions
from bt_orchestrator.extensions.opcua.server.overrides.views import Views


class Inside(InternalServer):
    """The inner server, which all connections share."""

    method_service: MethodService
    view_service: Views

    def __init__(self, security: Security) -> None:
        super().__init__()
        self.security = security
        filters.install()
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
        return [one for one in self._external_sessions.values() if isinstance(one, Session)]
