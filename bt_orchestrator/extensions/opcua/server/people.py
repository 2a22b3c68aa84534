"""Users of the OPC UA server: those of the one file, with their roles of now."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from bt_orchestrator.model.roles import Role
from bt_orchestrator.script.users.file import UsersUnusable
from bt_orchestrator.script.users.known import KnownUsers
from bt_orchestrator.script.users.logins import Logins
from bt_orchestrator.script.users.passwords import Hashed

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Person:
    """A user who has logged in."""

    name: str
    password: Hashed
    """With which they did; another one ends their sessions."""


class People:
    """Carries out logins, and knows who may still do what. For the loop's thread."""

    def __init__(self, users: Path, clock: Callable[[], float] = time.monotonic) -> None:
        """Begin without failures.

        :param users: file of users
        :param clock: steady, seconds
        """
        self._users = KnownUsers(users)
        self._logins = Logins('opcua', self._users, clock, log)

    async def log_in(self, name: str, password: str, address: str) -> Person:
        """Return who somebody is.

        :raises LoginRefused: there is no such user, or the password is another one
        :raises MustWait: there were too many attempts
        :raises UsersUnusable: nobody can log in
        """
        user = await self._logins.verify(name, password, address)
        log.info('%s (%s) logged in from %s', name, user.role.value, address)
        return Person(name, user.password)

    def role_of(self, person: Person) -> Role | None:
        """Return the role of now; None: the user was removed, or has another password."""
        try:
            user = self._users.get(person.name)
        except UsersUnusable as error:
            log.warning('%s', error)
            return None
        return user.role if user is not None and user.password == person.password else None

    def close(self) -> None:
        """Check no more passwords."""
        self._logins.close()
