"""How often somebody may try to log in."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass

FREE_OF_NAME, FREE_OF_ADDRESS = 5, 20
"""Failures that cost no wait: typing is hard, and several people share a computer."""

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
    """Failed logins, by name and by address. Times are of a steady clock.

    Each failure beyond the free ones doubles the wait.
    """

    def __init__(self) -> None:
        self._known: dict[Hashable, _Failures] = {}

    def wait_s(self, name: str, address: str, now: float) -> float:
        """Return for how long there may be no attempt, seconds; 0: it may be made."""
        return max(
            (
                self._known[key].wait_s(free, now)
                for key, free in _keys(name, address)
                if key in self._known
            ),
            default=0.0,
        )

    def begin(self, name: str, address: str, now: float) -> None:
        """Count an attempt as failed before it is known: several may be under way at once."""
        for key, _ in _keys(name, address):
            failures = self._known.pop(key, None) or _Failures()
            failures.count, failures.last = failures.count + 1, now
            self._known[key] = failures
        while len(self._known) > MOST_KNOWN:
            del self._known[next(iter(self._known))]

    def succeeded(self, name: str, address: str) -> None:
        """Forget the failures of a name; of the address only this attempt.

        Somebody with a password of their own could else guess at others for ever.
        """
        (of_name, _), (of_address, _) = _keys(name, address)
        self._known.pop(of_name, None)
        if of_address in self._known:
            self._known[of_address].count -= 1


def _keys(name: str, address: str) -> tuple[tuple[Hashable, int], tuple[Hashable, int]]:
    return (('name', name), FREE_OF_NAME), (('address', address), FREE_OF_ADDRESS)
