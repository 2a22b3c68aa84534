"""Rate limits per sender: an allowance shrinks with use and recovers with time."""

from __future__ import annotations

import math
from collections.abc import Hashable

from bt_orchestrator.model.limits import Share

SENDERS = 200
"""Maximum number of senders with their own allowance; all others share one."""


class Allowance:
    """The rest of a share. All times are of a steady clock."""

    def __init__(self, share: Share) -> None:
        self._share = share
        self._left = share.at_once
        self._at = -math.inf

    def left(self, now: float) -> float:
        """Return how much may be used now; below 0: overdrawn."""
        grown = self._left + self._share.per_s * (now - self._at)
        self._left, self._at = min(self._share.at_once, grown), now
        return self._left

    def use(self, amount: float, now: float) -> None:
        """Subtract what was used."""
        self._left = self.left(now) - amount

    def is_full(self, now: float) -> bool:
        """Tell whether it has recovered completely."""
        return self.left(now) >= self._share.at_once


class Allowances:
    """One allowance for each sender, and one for all together.

    Senders choose their names: one that changes its name with each request still has only the
    common share.
    """

    def __init__(self, each: Share, together: Share) -> None:
        self._each = each
        self._together = Allowance(together)
        self._own: dict[Hashable, Allowance] = {}
        self._others = Allowance(each)

    def left(self, sender: Hashable, now: float) -> float:
        """Return how much a sender may use now."""
        return min(self._of(sender, now).left(now), self._together.left(now))

    def use(self, sender: Hashable, amount: float, now: float) -> None:
        """Subtract what a sender used."""
        self._of(sender, now).use(amount, now)
        self._together.use(amount, now)

    def _of(self, sender: Hashable, now: float) -> Allowance:
        if sender not in self._own and len(self._own) >= SENDERS:
            self._own = {who: own for who, own in self._own.items() if not own.is_full(now)}
            if len(self._own) >= SENDERS:
                return self._others
        return self._own.setdefault(sender, Allowance(self._each))
