"""Sessions of people at the page, kept in memory: a page that starts anew asks for the login."""

from __future__ import annotations

import secrets
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from bt_orchestrator.model.by import Known
from bt_orchestrator.model.roles import Role
from bt_orchestrator.script.users.passwords import Hashed

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
        own = [key for key, one in self._kept.items() if one.name == name]
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
            key: one for key, one in self._kept.items() if now - one.began < self.session_s
        }
