"""How often somebody may try to log in."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass

FREE = 5
"""Failures with a name from an address that cost no wait: typing is hard."""

FREE_OF_MANY = 100
"""The same of an address with all names, and of a name from all addresses: twenty people who type
badly. Only free failures count here, so a program with a wrong password, however long it tries,
keeps out neither its neighbours nor its namesakes elsewhere."""

LONGEST_S = 60.0
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
        pause = min(LONGEST_S, 2.0 ** min(over, 10))
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
        limits = [(pair, FREE), *((key, FREE_OF_MANY) for key in many)]
        return max(
            (self._known[key].wait_s(free, now) for key, free in limits if key in self._known),
            default=0.0,
        )

    def begin(self, name: str, address: str, now: float) -> None:
        """Count an attempt as failed before it is known: several may be under way at once."""
        pair, *many = _keys(name, address)
        if self._count(pair, now) <= FREE:
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
        if failures is not None and failures.count <= FREE:
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
