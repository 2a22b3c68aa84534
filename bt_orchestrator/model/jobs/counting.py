"""The count of an item when it leaves the line, for every surface (semantics 6.2)."""

from __future__ import annotations

MISSING, BY_HAND, PACKED = 'missing', 'by_hand', 'packed'
"""How an item ended: never placed, taken off the belt by an operator, out at the sink."""

APPROVED, PIECE_REFUSED, PIECE_WAITS = 'approved', 'refused', 'waits'
"""The state of a first piece (semantics 6.12)."""

GOOD, NONCONFORMING, REJECTED = 'good', 'nonconforming', 'rejected'


def kind_of(how: str, *, is_nonconforming: bool) -> str:
    """Return good, nonconforming, rejected or by_hand.

    :param how: it was taken out: packed, rejected or by_hand
    :param is_nonconforming: as it leaves; a later mark changes no count
    """
    if how == PACKED:
        return NONCONFORMING if is_nonconforming else GOOD
    return BY_HAND if how == BY_HAND else REJECTED


def counts_of(how: str, *, is_nonconforming: bool) -> tuple[str, ...]:
    """Return the counts of its job that an item adds to; the parameters are those of `kind_of`."""
    return _ADDS[kind_of(how, is_nonconforming=is_nonconforming)]


_ADDS = {
    GOOD: (PACKED,),
    NONCONFORMING: (PACKED, NONCONFORMING),
    REJECTED: (REJECTED,),
    BY_HAND: (MISSING, BY_HAND),
}


def good_of(packed: int, nonconforming: int) -> int:
    """Return how many items are good (ISO 22400: good quantity).

    :param nonconforming: of the packed ones; older journals counted others, too
    """
    return max(packed - nonconforming, 0)


def produced_of(packed: int, rejected: int, by_hand: int) -> int:
    """Return how many items were placed and have left (ISO 22400: produced quantity)."""
    return packed + rejected + by_hand
