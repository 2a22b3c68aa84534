"""The plain way: asyncua's own server, of what asyncua promises to keep, which users only read.

asyncua does not tell a method who calls it, looks at no certificates and sets no limits
(docs/decisions/0037). So there are no commands, and it is for clients at this computer.
"""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

import asyncua
from asyncua import ua
from asyncua.crypto.permission_rules import PermissionRuleset, User, UserRole
from asyncua.server.user_managers import UserManager
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.extensions.opcua.server.library import building
from bt_orchestrator.extensions.opcua.server.overrides import services
from bt_orchestrator.extensions.opcua.server.overrides.security import People, Person, Security

log = logging.getLogger(__name__)


class PlainServer(asyncua.Server):
    """Users log in, and read."""

    def __init__(self, security: Security) -> None:
        """Prepare; `init` and `start` follow."""
        readers = Readers(security.people)
        super().__init__(user_manager=readers)
        self._own = security.own
        self.set_security_policy(security.policies, Reading(readers))
        self.set_identity_tokens([ua.UserNameIdentityToken])

    async def init(self, shelf_file: Path | None = None) -> None:
        """Load the nodes of every server, and the proof of who it is."""
        with building():
            await super().init(shelf_file)
        await self.set_application_uri(self._own.uri)
        await self.load_certificate(self._own.certificate.public_bytes(Encoding.DER), 'der')
        key = self._own.key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())
        await self.load_private_key(key, None, 'pem')


class Readers(UserManager):
    """Lets users in by their passwords."""

    def __init__(self, people: People) -> None:
        self._people = people
        self._persons: dict[str, Person] = {}

    def get_user(
        self,
        iserver: Any,
        username: str | None = None,
        password: str | bytes | None = None,
        certificate: Any = None,
    ) -> User | None:
        """Return a user who has said the right password; None: there is none."""
        del iserver, certificate
        if not username or password is None:
            return None
        said = password.decode(errors='replace') if isinstance(password, bytes) else password
        try:
            person = self._people.log_in_here(username, said)
        except OrchestratorError as error:
            log.warning('%s', error)
            return None
        self._persons[person.name] = person
        return User(role=UserRole.User, name=person.name)

    def may_read(self, name: str | None) -> bool:
        """Tell whether a user who was let in is one still, with the same password."""
        person = self._persons.get(name or '')
        return person is not None and self._people.role_of(person) is not None


class Reading(PermissionRuleset):
    """Lets users do what changes nothing."""

    def __init__(self, readers: Readers) -> None:
        self._readers = readers

    def check_validity(self, user: Any, action_type_id: ua.NodeId, body: Any) -> bool:
        """Tell whether a request of somebody is carried out."""
        del body
        return action_type_id in services.READING and self._readers.may_read(user.name)
