"""The list of a section: what leads, what needs the belt, what trails, what runs side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from bt_orchestrator.extensions.recipes.planning.pieces import Choice, Pieces


class Entry(NamedTuple):
    """A piece in a section."""

    piece: int
    choice: Choice


Track = tuple[Entry, ...]
Group = tuple[Track, ...]
"""Tracks that run side by side; mostly one of one piece."""


@dataclass(frozen=True)
class Listed:
    """The list of one section."""

    groups: tuple[Group, ...]
    releases_early: bool
    """Its last groups run while the belt moves."""


def listed(pieces: Pieces, entries: Sequence[Entry]) -> Listed:
    """Make the list of a section.

    What needs no belt leads, if nothing that needs it comes before, so that it runs ahead. It
    trails if nothing but what trails comes behind, wherever that is done: the item has left by
    then. A task that may reject cannot trail; where it has to be behind the last one that needs
    the belt, nothing is released early (semantics 3.7, 3.8).

    :param entries: in the order of their numbers
    """
    lead, middle, trail = _parted(pieces, entries)
    if trail and not middle[-1].choice.needs_belt:
        closing = _closing(pieces, middle)
        if closing is None:
            middle, trail = [*middle, *trail], []
        else:
            middle = [*(entry for entry in middle if entry is not closing), closing]
    parts = [_side_by_side(pieces, part) for part in (lead, middle, trail)]
    return Listed(tuple(group for part in parts for group in part), bool(trail))


def _parted(
    pieces: Pieces, entries: Sequence[Entry]
) -> tuple[list[Entry], list[Entry], list[Entry]]:
    here = sum(1 << entry.piece for entry in entries)
    leading = 0
    for entry in entries:
        before = pieces.all_before[entry.piece] & here
        if not entry.choice.needs_belt and not before & ~leading:
            leading |= 1 << entry.piece
    trailing, rest = 0, here & ~leading
    for entry in reversed(entries):
        behind, stays = (
            pieces.all_behind[entry.piece],
            entry.choice.needs_belt or entry.choice.may_reject,
        )
        if rest >> entry.piece & 1 and not behind & ~trailing and not stays:
            trailing |= 1 << entry.piece
    middle = rest & ~trailing
    lead, between, trail = (
        [entry for entry in entries if part >> entry.piece & 1]
        for part in (leading, middle, trailing)
    )
    return lead, between, trail


def _closing(pieces: Pieces, middle: Sequence[Entry]) -> Entry | None:
    """Return what can be the last one that needs the belt; None: something has to come behind."""
    here = sum(1 << entry.piece for entry in middle)
    return next(
        (
            entry
            for entry in reversed(middle)
            if entry.choice.needs_belt and not pieces.all_behind[entry.piece] & here
        ),
        None,
    )


# --- side by side -----------------------------------------------------------------------------


def _side_by_side(pieces: Pieces, entries: Sequence[Entry]) -> list[Group]:
    """Part entries into groups that take the least time one after the other.

    The entries of a group fall into tracks that have nothing to do with each other.
    """
    if sum(not entry.choice.is_alone for entry in entries) < 2:
        return [((entry,),) for entry in entries]
    best: list[tuple[int, int, list[Group]]] = [(0, 0, [])]
    for end in range(1, len(entries) + 1):
        ways = []
        for begin in range(end):
            group = _tracks(pieces, entries[begin:end])
            if end - begin > 1 and len(group) == 1:
                continue  # as long as its parts alone
            us, size, before = best[begin]
            ways.append((us + _us(group), size + (len(group) > 1), [*before, group]))
        best.append(min(ways, key=lambda way: way[:2]))
    return best[-1][2]


def _tracks(pieces: Pieces, entries: Sequence[Entry]) -> Group:
    tracks: list[list[Entry]] = []
    for entry in entries:
        met = [track for track in tracks if any(_meet(pieces, entry, other) for other in track)]
        joined = [other for track in met for other in track]
        tracks = [track for track in tracks if track not in met]
        tracks.append([*sorted(joined), entry] if joined else [entry])
    tracks.sort(key=lambda track: track[0].piece)
    return tuple(map(tuple, tracks))


def _meet(pieces: Pieces, entry: Entry, other: Entry) -> bool:
    """Tell whether two pieces cannot run at the same time."""
    if entry.choice.is_alone or other.choice.is_alone:
        return True
    ordered = (
        pieces.all_before[entry.piece] >> other.piece
        | pieces.all_before[other.piece] >> entry.piece
    )
    return bool(ordered & 1) or not entry.choice.spaces.isdisjoint(other.choice.spaces)


def _us(group: Group) -> int:
    return max(sum(entry.choice.us for entry in track) for track in group)
