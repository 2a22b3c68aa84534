"""Logins: passwords are checked one at a time, outside the loop, and attempts are limited."""

from __future__ import annotations

import asyncio
import logging
import math
from collections.abc import Callable, Hashable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.model.limits import WHO, cut
from bt_orchestrator.script.users.file import KnownUsers, User

MOST_WAITING = 8
"""Logins that wait for their turn: each takes a fifth of a second of CPU."""


class LoginRefused(OrchestratorError):
    """No such user, or another password; says no more than that."""


class MustWait(OrchestratorError):
    """Too many attempts."""

    def __init__(self, wait_s: float) -> None:
        self.wait_s = math.ceil(wait_s)
        super().__init__(f'too many attempts to log in; try again in {self.wait_s} s')


class Logins:
    """Checks passwords for a program. All calls come from the loop's thread."""

    def __init__(
        self,
        program: str,
        users: KnownUsers,
        clock: Callable[[], float],
        log: logging.Logger,
    ) -> None:
        """Begin without failures.

        :param program: its name, for that of the thread
        :param clock: steady, seconds
        :param log: of the program
        """
        self._users = users
        self._clock = clock
        self._log = log
        self._attempts = Attempts()
        # One at a time, or guesses would take every core of the line's computer.
        self._checks = ThreadPoolExecutor(1, thread_name_prefix=f'{program}: passwords')
        self._waiting = 0

    async def verify(self, name: str, password: str, address: str) -> User:
        """Return the user with this name and password.

        :param address: where the attempt comes from
        :raises LoginRefused: there is no such user, or the password is another one
        :raises MustWait: there were too many attempts
        :raises UsersUnusable: nobody can log in
        """
        shown = self._begin(name, address)
        return self._end(await self.check(name, password), shown, address)

    def verify_here(self, name: str, password: str, address: str) -> User:
        """Do the same in this thread, which has nothing else to do meanwhile.

        :raises LoginRefused, MustWait, UsersUnusable: as `verify`
        """
        shown = self._begin(name, address)
        return self._end(self._users.verify(name, password), shown, address)

    def _begin(self, name: str, address: str) -> str:
        """Count an attempt; returns the name as it is shown."""
        now, shown = self._clock(), cut(name, WHO)
        wait_s = self._attempts.wait_s(shown, address, now)
        if wait_s > 0:
            raise MustWait(wait_s)
        self._attempts.begin(shown, address, now)
        return shown

    def _end(self, user: User | None, shown: str, address: str) -> User:
        if user is None:
            self._log.warning('login refused: %r from %s', shown, address)
            raise LoginRefused('there is no user with this name and password')
        self._attempts.succeeded(shown, address)
        return user

    async def check(self, name: str, password: str) -> User | None:
        """Return the user with this name and password; None: there is none. Counts nothing.

        :raises MustWait: too many passwords are being checked
        :raises UsersUnusable: nobody can log in
        """
        if self._waiting >= MOST_WAITING:
            raise MustWait(1.0)
        self._waiting += 1
        try:
            loop = asyncio.get_running_loop()
            return await loop.run_in_executor(self._checks, self._users.verify, name, password)
        finally:
            self._waiting -= 1

    def close(self) -> None:
        """Check no more passwords."""
        self._checks.shutdown(wait=False, cancel_futures=True)


# How often somebody may try to log in.

FREE_ATTEMPTS = 5
"""Failures with a name from an address that cost no wait: typing is hard."""

FREE_ATTEMPTS_OF_MANY = 100
"""The same of an address with all names, and of a name from all addresses: twenty people who type
badly. Only free failures count here, so a program with a wrong password, however long it tries,
keeps out neither its neighbours nor its namesakes elsewhere."""

LONGEST_WAIT_S = 60.0
"""Longest wait: somebody who guesses at a name must not keep its owner out for long."""

FORGOTTEN_S = 15 * 60.0
"""Failures count until there was none for so long."""

MOST_KNOWN = 2_000
"""Names and addresses that are remembered at a time."""


@dataclass
class _Failures:
    count: int = 0
    last: float = 0.0

    def wait_s(self, free: int, now: float) -> float:
        if now - self.last >= FORGOTTEN_S:
            self.count = 0
        over = self.count - free
        if over < 0:
            return 0.0
        pause = min(LONGEST_WAIT_S, 2.0 ** min(over, 10))
        return max(0.0, self.last + pause - now)


class Attempts:
    """Failed logins: with a name from an address, from an address, with a name.

    Times are of a steady clock. Each failure beyond the free ones doubles the wait.
    """

    def __init__(self) -> None:
        self._known: dict[Hashable, _Failures] = {}

    def wait_s(self, name: str, address: str, now: float) -> float:
        """Return for how long there may be no attempt, seconds; 0: it may be made."""
        pair, *many = _keys(name, address)
        limits = [(pair, FREE_ATTEMPTS), *((key, FREE_ATTEMPTS_OF_MANY) for key in many)]
        return max(
            (self._known[key].wait_s(free, now) for key, free in limits if key in self._known),
            default=0.0,
        )

    def begin(self, name: str, address: str, now: float) -> None:
        """Count an attempt as failed before it is known: several may be under way at once."""
        pair, *many = _keys(name, address)
        if self._count(pair, now) <= FREE_ATTEMPTS:
            for key in many:
                self._count(key, now)
        while len(self._known) > MOST_KNOWN:
            del self._known[next(iter(self._known))]

    def succeeded(self, name: str, address: str) -> None:
        """Forget the failures of a name from an address; of both otherwise only this attempt.

        Somebody with a password of their own could else guess at others for ever.
        """
        pair, *many = _keys(name, address)
        failures = self._known.pop(pair, None)
        if failures is not None and failures.count <= FREE_ATTEMPTS:
            for key in many:
                if key in self._known:
                    self._known[key].count -= 1

    def _count(self, key: Hashable, now: float) -> int:
        failures = self._known.pop(key, None) or _Failures()
        failures.count, failures.last = failures.count + 1, now
        self._known[key] = failures
        return failures.count


def _keys(name: str, address: str) -> tuple[Hashable, ...]:
    return (name, address), ('address', None, address), ('name', name, None)
