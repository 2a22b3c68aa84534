"""The identity of a person at the page, by a login, a proxy or a trusted computer; sessions."""

from __future__ import annotations

import logging
import secrets
import time
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from bt_orchestrator.extensions.page.web.access import Access
from bt_orchestrator.model.by import Known, Role
from bt_orchestrator.ports.doors.listening import is_loopback
from bt_orchestrator.script.users.file import KnownUsers, User, UsersUnusable
from bt_orchestrator.script.users.logins import LoginRefused, Logins
from bt_orchestrator.script.users.passwords import Hashed

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Caller:
    """The facts of a request before its sender is known."""

    address: str = ''
    """Of the other end of the connection; empty: not known."""
    key: str = ''
    """Id of a session; empty: none."""
    proxied: str = ''
    """User that the header of a proxy names; empty: none."""


class People:
    """Knows callers, and carries out logins. All calls come from the loop's thread."""

    def __init__(self, access: Access, clock: Callable[[], float] = time.monotonic) -> None:
        """Begin without sessions.

        :param clock: steady, seconds
        """
        self.access = access
        self._users = KnownUsers(access.users)
        self._sessions = Sessions(clock, idle_s=access.idle_s, session_s=access.session_s)
        self._logins = Logins('page', self._users, clock, log)

    # --- who calls ------------------------------------------------------------------------------

    def who(self, caller: Caller) -> Session | None:
        """Return who calls; None: somebody whom the page does not know."""
        if self.access.proxy_header:
            return self._by_proxy(caller)
        kept = self._kept(caller.key)
        if kept is not None:
            return self._session(kept, caller.address)
        if self.access.local_user and is_loopback(caller.address):
            return Session(self.access.local_user, Role.ENGINEER, How.COMPUTER)  # never a panel
        return None

    def may_look(self, caller: Caller) -> bool:
        """Tell whether a caller may look; asked again and again while a stream is open."""
        return self.access.looks_freely or self.who(caller) is not None

    def _by_proxy(self, caller: Caller) -> Session | None:
        if not caller.proxied or not self.access.is_proxy(caller.address):
            return None
        user = self._user(caller.proxied)
        if user is None:
            return None
        is_panel = self._is_panel(caller.proxied)  # the address is that of the proxy
        return Session(caller.proxied, user.role, How.PROXY, is_panel=is_panel)

    def _is_panel(self, name: str, address: str = '') -> bool:
        try:
            return self._users.panels().have(name, address)
        except UsersUnusable:
            return False

    def _kept(self, key: str) -> Kept | None:
        """Return a session that goes on: its user is there, with the same password."""
        kept = self._sessions.get(key)
        if kept is None:
            return None
        user = self._user(kept.name)
        if user is None or user.password != kept.password:
            self._sessions.end(key)
            return None
        return kept

    def _session(self, kept: Kept, address: str) -> Session:
        user = self._user(kept.name)
        idle_left_s = None if kept.is_locked else self._sessions.idle_left_s(kept)
        return Session(
            kept.name,
            Role.VIEW if user is None else user.role,
            How.LOGIN,
            kept.is_locked,
            self._sessions.left_s(kept),
            idle_left_s,
            self._is_panel(kept.name, address),
        )

    def _user(self, name: str) -> User | None:
        try:
            return self._users.get(name)
        except UsersUnusable as error:
            log.warning('%s', error)
            return None

    # --- what they do ---------------------------------------------------------------------------

    async def log_in(self, caller: Caller, name: str, password: str) -> str:
        """Begin a session and return its id; a session that the caller had is over.

        :raises LoginRefused: there is no such user, or the password is another one
        :raises MustWait: there were too many attempts
        :raises UsersUnusable: nobody can log in
        """
        user = await self._logins.verify(name, password, caller.address)
        self._sessions.end(caller.key)
        log.info('%s (%s) logged in from %s', name, user.role.value, caller.address)
        return self._sessions.begin(name, user.password)

    def log_out(self, caller: Caller) -> None:
        """End the session of a caller."""
        kept = self._sessions.get(caller.key)
        if kept is not None:
            log.info('%s logged out', kept.name)
            self._sessions.end(caller.key)

    def use(self, caller: Caller) -> None:
        """Take note that somebody does something with a session."""
        kept = self._kept(caller.key)
        if kept is not None:
            self._sessions.use(kept)

    def lock(self, caller: Caller) -> None:
        """Lock the session of a caller."""
        kept = self._kept(caller.key)
        if kept is not None:
            kept.is_locked = True

    async def unlock(self, caller: Caller, password: str) -> None:
        """Unlock the session of a caller.

        Wrong passwords are counted by session, so that nobody else can keep somebody out.

        :raises LoginRefused: it is another password, or there is no session any more
        :raises MustWait: too many passwords are being checked
        :raises UsersUnusable: nobody can log in
        """
        kept = self._kept(caller.key)
        if kept is None:
            raise LoginRefused('this session has ended; log in again')
        kept.wrong_passwords += 1  # before it is known: several may be under way at once
        if kept.wrong_passwords > MOST_UNLOCKS:
            self._sessions.end(caller.key)
            log.warning('session of %s ended after wrong passwords', kept.name)
            raise LoginRefused('too many wrong passwords: this session has ended; log in again')
        if await self._logins.check(kept.name, password) is None:
            raise LoginRefused('this is not the password')
        self._sessions.unlock(kept)

    def close(self) -> None:
        """Check no more passwords."""
        self._logins.close()


# Sessions of people at the page, kept in memory: a page that starts anew asks for the login.

MOST, MOST_OF_ONE = 500, 20
"""Sessions at a time, of all users and of one; the oldest ends for a new one."""

MOST_UNLOCKS = 5
"""Wrong passwords after which a locked session ends."""


class How(Enum):
    """How the page knows somebody."""

    LOGIN = 'page login'
    PROXY = 'proxy'
    """A proxy that the page trusts has named the user."""
    COMPUTER = 'this computer'
    """There is no login: the person at this computer is trusted."""

    @property
    def known(self) -> Known:
        """The sender for the node: a name without proof stays a claim."""
        return Known.ROS if self is How.COMPUTER else Known.PAGE_LOGIN


@dataclass(frozen=True)
class Session:
    """Somebody, as one request found them."""

    name: str
    role: Role
    how: How
    is_locked: bool = False
    left_s: float | None = None
    """Seconds until it ends; None: it does not."""
    idle_left_s: float | None = None
    """Seconds until it is locked, unless it is used; None: it does not lock, or it is locked."""
    is_panel: bool = False
    """It is at a panel of the line (semantics 7.8)."""

    @property
    def known(self) -> Known:
        """The knowledge of the sender that the node gets."""
        return self.how.known.at_panel() if self.is_panel else self.how.known


@dataclass
class Kept:
    """The kept facts of a session of a login."""

    name: str
    password: Hashed
    """The one that it began with: with another one it is over."""
    began: float
    used: float
    is_locked: bool = False
    wrong_passwords: int = 0


class Sessions:
    """By the random id in the cookie."""

    def __init__(self, clock: Callable[[], float], *, idle_s: float, session_s: float) -> None:
        """Begin with none.

        :param clock: steady, seconds
        """
        self._clock = clock
        self.idle_s = idle_s
        self.session_s = session_s
        self._kept: dict[str, Kept] = {}

    def begin(self, name: str, password: Hashed) -> str:
        """Begin a session and return its id."""
        now = self._clock()
        self._forget_ended(now)
        own = [key for key, session in self._kept.items() if session.name == name]
        for key in own[: max(0, len(own) - MOST_OF_ONE + 1)]:
            del self._kept[key]
        while len(self._kept) >= MOST:
            del self._kept[next(iter(self._kept))]
        key = secrets.token_urlsafe(32)
        self._kept[key] = Kept(name, password, began=now, used=now)
        return key

    def get(self, key: str) -> Kept | None:
        """Return a session, locked if it was idle for too long; None: there is none any more."""
        kept, now = self._kept.get(key), self._clock()
        if kept is None:
            return None
        if self.left_s(kept) <= 0:
            self.end(key)
            return None
        if now - kept.used >= self.idle_s:
            kept.is_locked = True
        return kept

    def left_s(self, kept: Kept) -> float:
        """Return how long a session goes on, seconds."""
        return kept.began + self.session_s - self._clock()

    def idle_left_s(self, kept: Kept) -> float:
        """Return after how long it is locked unless it is used, seconds."""
        return kept.used + self.idle_s - self._clock()

    def use(self, kept: Kept) -> None:
        """Take note that a person did something; a locked session stays locked."""
        if not kept.is_locked:
            kept.used = self._clock()

    def unlock(self, kept: Kept) -> None:
        """Unlock a session whose password was given."""
        kept.is_locked, kept.wrong_passwords, kept.used = False, 0, self._clock()

    def end(self, key: str) -> None:
        """End a session, if it is still there."""
        self._kept.pop(key, None)

    def _forget_ended(self, now: float) -> None:
        self._kept = {
            key: session
            for key, session in self._kept.items()
            if now - session.began < self.session_s
        }
