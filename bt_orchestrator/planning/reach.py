"""The sections that each piece can be in, because the belt moves one way; or why there are none.

Every condition here says that one section is not behind another one, or at most so many behind.
For such conditions it is enough to take away what nothing else fits to, again and again: if every
piece has a section left, the first ones of all fit together, and if one has none, nothing does.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from bt_orchestrator.planning.candidates import Candidate
from bt_orchestrator.planning.contradiction import Demand, irreducible, narrowed
from bt_orchestrator.planning.order import Ends
from bt_orchestrator.planning.pieces import Pieces


@dataclass(frozen=True)
class Held:
    """Data that a device keeps itself, from one operation to the last one that needs it."""

    name: str
    giver: str
    takers: tuple[str, ...]
    """In the order of the recipe."""

    def is_kept_by(self, one: Candidate) -> bool:
        """Tell whether the device keeps it; else it travels with the item, in the results."""
        can = one.capability
        return one.operation.id == self.giver and self.name in {*can.holds} - {*can.gives}


@dataclass(frozen=True)
class _Link:
    """One piece is not done in a section before that of another one."""

    first: int
    second: int
    because: str = ''
    """Why, if not by the recipe."""


@dataclass
class Reach:
    """The sections of each piece, ascending, and the first reason why there may be none."""

    pieces: Pieces
    line: Ends
    held: tuple[Held, ...] = ()
    sections: list[list[int]] = field(init=False)
    reason: str = field(default='', init=False)

    def __post_init__(self) -> None:
        choices = self.pieces.choices
        self.reason = self._why_not_kept()
        for names, ways in zip(self.pieces.members, choices, strict=True):
            if not ways:
                self.reason = f'no section has components for all of {_list(names)}, which repeat'
        self.sections = [sorted({one.section for one in ways}) for ways in choices]
        if not self.reason:
            self._narrow()

    def _why_not_kept(self) -> str:
        """Say which device would have to keep the same thing for two operations, or rounds."""
        kept: dict[tuple[str, str], str] = {}
        for one in self.held:
            ways = self.pieces.choices[self.pieces.number_of[one.giver]]
            members = [member for way in ways for member in way.members]
            mine = [member for member in members if member.operation.id == one.giver]
            names = {member.component.name for member in mine}
            if len(names) != 1 or not all(map(one.is_kept_by, mine)):
                continue
            (name,) = names
            key = name, one.name
            for other in (one.giver, *one.takers):
                if any(way.repeats for way in self.pieces.choices[self.pieces.number_of[other]]):
                    return (
                        f'{name} keeps `{one.name}` for {_list(one.takers)}, and `{other}` '
                        'repeats: it would be counted once a round; leave it out of the repeat'
                    )
            if key in kept:
                return (
                    f'only {name} can do `{kept[key]}` and `{one.giver}`, and it cannot keep '
                    f'`{one.name}` of both; a second component, or a name for each'
                )
            kept[key] = one.giver
        return ''

    @property
    def links(self) -> Iterator[tuple[int, int]]:
        """Yield which piece is not done behind which other one."""
        return ((one.first, one.second) for one in self._links)

    @property
    def _links(self) -> list[_Link]:
        pieces = self.pieces
        found = [_Link(one, other) for other, ways in enumerate(pieces.before) for one in ways]
        places = pieces.number_of[self.line.places]
        lasts = [pieces.number_of[one] for one in self.line.takes]
        for number in range(len(pieces)):
            if number != places:
                found.append(_Link(places, number, 'places'))
            if len(lasts) == 1 and number != lasts[0]:
                found.append(_Link(number, lasts[0], 'takes'))
        return found

    def _narrow(self) -> None:
        """Take away what does not fit, or say what contradicts what."""
        links = {Demand(self._words(one), one.first, one.second): one for one in self._links}
        number_of = self.pieces.number_of
        kept = {
            self._room(number_of[one.giver], number_of[taker], one): one
            for one in self.held
            for taker in one.takers
        }
        demands = [*links, *kept, *map(self._where, range(len(self.pieces)))]
        most = max(one[-1] for one in self.sections)
        left = narrowed(demands, len(self.pieces), most)
        if all(left):
            self.sections = [sorted(one) for one in left]
            return
        needed = irreducible(demands, len(self.pieces), most)
        first, *others = [one for one in needed if one.second >= 0]
        if others:
            told = '; '.join(one.words for one in needed)
            self.reason = (
                f'items move down the belt only, and these demands contradict each other: {told}'
            )
        elif first in links:
            self.reason = self._backwards(links[first])
        else:
            self.reason = self._too_far(first, kept[first])

    def _too_far(self, demand: Demand, held: Held) -> str:
        here = self.sections[demand.first][-1]
        count = self.capacity(demand.first, here, held.name)
        away = self.sections[demand.second][0] - here
        return (
            f'{self._who(demand.first, here)} holds {count} `{held.name}`, but '
            f'`{held.takers[-1]}` is {away} sections on; bind nearer, or the device must keep '
            f'{away}'
        )

    def capacity(self, giver: int, section: int, name: str) -> int:
        """Return how many a device of a section keeps; without limit where the results travel."""
        found = [
            _kept(member, name)
            for choice in self.pieces.choices[giver]
            if choice.section == section
            for member in choice.members
            if name in member.capability.holds or name in member.capability.gives
        ]
        return max(found)

    def _backwards(self, link: _Link) -> str:
        first, second = self.pieces.members[link.first][0], self.pieces.members[link.second][0]
        early, late = self.sections[link.first][0], self.sections[link.second][-1]
        only = f'`{second}` only at {self._who(link.second, late)} in section {late}'
        if link.because == 'places':
            return f'items are placed by `{first}` in section {early} at the earliest, and {only}'
        if link.because == 'takes':
            who = self._who(link.first, early)
            return (
                f'`{first}` is done by {who} in section {early} at the earliest, and `{second}` '
                f'takes the item out in section {late}'
            )
        return (
            f'`{second}` cannot come behind `{first}`: that is done in section {early} at the '
            f'earliest and {only}; items move down the belt only'
        )

    def _words(self, link: _Link) -> str:
        first, second = self.pieces.members[link.first][0], self.pieces.members[link.second][0]
        return {
            'places': f'`{first}` places the item before `{second}`',
            'takes': f'`{second}` takes the item out after `{first}`',
        }.get(link.because, f'`{second}` comes after `{first}`')

    def _where(self, piece: int) -> Demand:
        """Say where a piece can be done, whatever the others need."""
        sections = self.sections[piece]
        told = ' or '.join(f'at {self._who(piece, one)} in section {one}' for one in sections)
        name = self.pieces.members[piece][0]
        return Demand(f'`{name}` only {told}', piece, sections=tuple(sections))

    def _room(self, giver: int, taker: int, held: Held) -> Demand:
        """Say how far what a device keeps may go."""
        room = {one: self.capacity(giver, one, held.name) for one in self.sections[giver]}
        most = max(room.values())
        return Demand(
            f'`{self.pieces.members[taker][0]}` at most {most} sections behind '
            f'`{held.giver}`, whose device holds {most} `{held.name}`',
            giver,
            taker,
            room=tuple((one, one + many) for one, many in room.items()),
        )

    def _who(self, piece: int, section: int) -> str:
        names = dict.fromkeys(
            choice.members[0].component.name
            for choice in self.pieces.choices[piece]
            if choice.section == section
        )
        return ' or '.join(names)


def _kept(candidate: Candidate, name: str) -> int:
    """Return for how many items something is kept; what travels with the item has no limit."""
    if name in candidate.capability.gives:
        return 1_000_000
    return candidate.capability.holds[name]


def _list(names: tuple[str, ...]) -> str:
    return ', '.join(f'`{name}`' for name in names)
