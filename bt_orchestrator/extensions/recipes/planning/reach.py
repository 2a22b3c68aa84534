"""The sections that each piece can be in, because the belt moves one way; or why there are none.

Every condition here says that one section is not behind another one, or at most so many behind.
For such conditions it is enough to take away what nothing else fits to, again and again: if every
piece has a section left, the first ones of all fit together, and if one has none, nothing does.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property

from bt_orchestrator.base.errors import counted
from bt_orchestrator.extensions.recipes.planning.candidates import Candidate
from bt_orchestrator.extensions.recipes.planning.order import Ends, quoted
from bt_orchestrator.extensions.recipes.planning.pieces import Pieces


@dataclass(frozen=True)
class Held:
    """Data that a device keeps itself, from one operation to the last one that needs it."""

    name: str
    giver: str
    takers: tuple[str, ...]
    """In the order of the recipe."""

    def is_kept_by(self, candidate: Candidate) -> bool:
        """Tell whether the device keeps it; else it travels with the item, in the results."""
        can = candidate.capability
        return candidate.operation.id == self.giver and self.name in {*can.holds} - {*can.gives}


@dataclass
class Reach:
    """The sections of each piece, ascending, and the reason why there may be none."""

    pieces: Pieces
    line: Ends
    held: tuple[Held, ...] = ()
    sections: list[list[int]] = field(init=False)
    reason: str = field(default='', init=False)

    def __post_init__(self) -> None:
        choices = self.pieces.choices
        for names, ways in zip(self.pieces.members, choices, strict=True):
            if not ways:
                self.reason = f'no section has components for all of {quoted(names)}, which repeat'
        self.sections = [sorted({way.section for way in ways}) for ways in choices]
        if not self.reason:
            self._narrow()

    @cached_property
    def links(self) -> list[Demand]:
        """The pieces that are not done behind others."""
        pieces, line = self.pieces, self.line
        names = [member[0] for member in pieces.members]
        demands = [
            Demand(f'`{names[second]}` comes after `{names[first]}`', first, second)
            for second, before in enumerate(pieces.before)
            for first in before
        ]
        places, takes = pieces.number_of[line.places], pieces.number_of[line.takes[0]]
        for number, name in enumerate(names):
            if number != places:
                words = f'`{names[places]}` places the item before `{name}`'
                demands.append(Demand(words, places, number))
            if len(line.takes) == 1 and number != takes:
                words = f'`{names[takes]}` takes the item out after `{name}`'
                demands.append(Demand(words, number, takes))
        return demands

    def _narrow(self) -> None:
        """Take away what does not fit, or say what contradicts what."""
        demands = [*self.links, *self._rooms(), *map(self._where, range(len(self.pieces)))]
        most = max(numbers[-1] for numbers in self.sections)
        left = narrowed(demands, len(self.pieces), most)
        self.sections = [sorted(numbers) for numbers in left]
        if not all(left):
            needed = irreducible(demands, len(self.pieces), most)
            self.reason = (
                'items move down the belt only, and these demands contradict each other: '
                + '; '.join(demand.words for demand in needed)
            )

    def _where(self, piece: int) -> Demand:
        """Say where a piece can be done, whatever the others need."""
        who: dict[int, dict[str, None]] = {section: {} for section in self.sections[piece]}
        for choice in self.pieces.choices[piece]:
            who[choice.section][choice.members[0].component.name] = None
        places = ' or '.join(
            f'at {" or ".join(components)} in section {n}' for n, components in who.items()
        )
        return Demand(f'`{self.pieces.members[piece][0]}` only {places}', piece, sections=(*who,))

    def _rooms(self) -> Iterator[Demand]:
        """Yield how far what a device keeps may go; what travels with the item has no limit."""
        number_of = self.pieces.number_of
        for held in self.held:
            giver, room = number_of[held.giver], dict[int, int]()
            for choice in self.pieces.choices[giver]:
                kept = [
                    member.capability.holds for member in choice.members if held.is_kept_by(member)
                ]
                many = kept[0][held.name] if kept else 1_000_000
                room[choice.section] = max(room.get(choice.section, 0), choice.section + many)
            most = max(last - section for section, last in room.items())
            for taker in held.takers:
                words = (
                    f'`{taker}` at most {counted(most, "section")} behind `{held.giver}`, whose '
                    f'device holds {most} `{held.name}`: bind nearer, or it has to hold more'
                )
                yield Demand(words, giver, number_of[taker], room=(*room.items(),))


# Demands that contradict each other; without any one of them there is no contradiction.


@dataclass(frozen=True)
class Demand:
    """A set of sections for one piece, or an order of two."""

    words: str
    first: int
    second: int = -1
    """Is done in no section before the first one; -1: the demand is about one piece."""
    sections: tuple[int, ...] = ()
    """Of the one piece."""
    room: tuple[tuple[int, int], ...] = ()
    """By section of the first piece, the last section of the second."""


def irreducible(demands: Sequence[Demand], pieces: int, sections: int) -> list[Demand]:
    """Return demands that no line meets; without any one of them there is one that does.

    :param demands: that no line meets together
    :param sections: of the belt
    """
    needed = list(demands)
    for demand in demands:
        others = [other for other in needed if other is not demand]
        if not all(narrowed(others, pieces, sections)):
            needed = others
    return needed


def narrowed(demands: Sequence[Demand], pieces: int, sections: int) -> list[set[int]]:
    """Return the sections of each piece that fit to others; of some there is none if none do."""
    left = [set(range(1, sections + 1)) for _ in range(pieces)]
    for demand in demands:
        if demand.second < 0:
            left[demand.first] &= {*demand.sections}
    pairs = [demand for demand in demands if demand.second >= 0]
    before = 0
    while all(left) and before != (before := sum(map(len, left))):
        for demand in pairs:
            first, second = left[demand.first], left[demand.second]
            last = dict(demand.room)
            fits = {
                here: {there for there in second if here <= there <= last.get(here, sections)}
                for here in first
            }
            left[demand.first] = {here for here in first if fits[here]}
            left[demand.second] = set().union(*fits.values())
    return left
