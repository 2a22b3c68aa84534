"""Logins: passwords are checked one at a time, outside the loop, and attempts are limited."""

from __future__ import annotations

import asyncio
import logging
import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.model.limits import WHO, cut
from bt_orchestrator.script.users.attempts import Attempts
from bt_orchestrator.script.users.file import User
from bt_orchestrator.script.users.known import KnownUsers

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
        now, shown = self._clock(), cut(name, WHO)
        wait_s = self._attempts.wait_s(shown, address, now)
        if wait_s > 0:
            raise MustWait(wait_s)
        self._attempts.begin(shown, address, now)
        user = await self.check(name, password)
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
