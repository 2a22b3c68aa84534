"""The pieces that are placed as a whole: an operation, or all operations of a `repeat`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from graphlib import CycleError, TopologicalSorter
from itertools import product

from bt_orchestrator.extensions.recipes.planning.candidates import Candidate
from bt_orchestrator.extensions.recipes.planning.order import Order
from bt_orchestrator.model.recipe import Recipe

MOST_CHOICES = 500
"""Of one repeat, whose members may have several candidates each."""


@dataclass(frozen=True, eq=False)
class Choice:
    """One way to do a piece: a candidate of each of its operations, all in one section."""

    members: tuple[Candidate, ...]
    repeats: bool = False
    """Its members are those of a `repeat`, which is a step of its own."""

    @cached_property
    def section(self) -> int:
        """Where it is done."""
        return self.members[0].section

    @cached_property
    def us(self) -> int:
        """Microseconds of all its members."""
        return sum(member.us for member in self.members)

    @cached_property
    def needs_belt(self) -> bool:
        """Tell whether the belt has to rest."""
        return any(member.needs_belt for member in self.members)

    @cached_property
    def may_reject(self) -> bool:
        """Tell whether the item may be rejected by it."""
        return any(member.may_reject for member in self.members)

    @cached_property
    def is_alone(self) -> bool:
        """Tell whether nothing may run beside it in its section."""
        return self.repeats or any(
            member.qty_change or not member.component.workspaces for member in self.members
        )

    @cached_property
    def spaces(self) -> frozenset[str]:
        """The things that no other may use at the same time."""
        return frozenset().union(*(member.spaces for member in self.members))


class Pieces:
    """The pieces of a recipe, in an order in which they can be done; each has a number."""

    def __init__(
        self, recipe: Recipe, order: Order, candidates: Mapping[str, Sequence[Candidate]]
    ) -> None:
        self.members, self.circle = _sorted(_grouped(recipe), order)
        """Ids of the operations of each piece."""
        self.number_of = {
            name: number for number, names in enumerate(self.members) for name in names
        }
        count = len(self.members)
        self.before: list[list[int]] = [[] for _ in range(count)]
        """Numbers of the pieces directly before each one."""
        self.behind: list[list[int]] = [[] for _ in range(count)]
        for number, names in enumerate(self.members):
            numbers = {self.number_of[earlier] for name in names for earlier in order.before[name]}
            self.before[number] = sorted(numbers - {number})
            for other in self.before[number]:
                self.behind[other].append(number)
        repeated = {name for rework in recipe.reworks for name in rework.operations}
        self.choices = [
            _choices([candidates[name] for name in names], names[0] in repeated)
            for names in self.members
        ]

    def __len__(self) -> int:
        return len(self.members)

    @cached_property
    def all_before(self) -> list[int]:
        """By piece: a bit for each one that comes before, directly or not."""
        return _closed(self.before, range(len(self)))

    @cached_property
    def all_behind(self) -> list[int]:
        """By piece: a bit for each one that comes later, directly or not."""
        return _closed(self.behind, range(len(self) - 1, -1, -1))


def _closed(next_to: Sequence[Sequence[int]], numbers: range) -> list[int]:
    masks = [0] * len(next_to)
    for number in numbers:
        for other in next_to[number]:
            masks[number] |= masks[other] | 1 << other
    return masks


def _grouped(recipe: Recipe) -> list[tuple[str, ...]]:
    """Return the ids of each piece, in the order written."""
    together = {name: rework.operations for rework in recipe.reworks for name in rework.operations}
    return list(
        dict.fromkeys(
            together.get(operation.id, (operation.id,)) for operation in recipe.operations
        )
    )


def _sorted(
    pieces: Sequence[tuple[str, ...]], order: Order
) -> tuple[list[tuple[str, ...]], tuple[str, ...]]:
    """Return pieces in an order that fits their waits; or a circle of waits."""
    of = {name: piece for piece in pieces for name in piece}
    waits = {
        piece: {of[earlier] for name in piece for earlier in order.before[name]} - {piece}
        for piece in pieces
    }
    try:
        TopologicalSorter({piece: sorted(others) for piece, others in waits.items()}).prepare()
    except CycleError as circle:
        return [], tuple(piece[0] for piece in circle.args[1])
    left, sequence = list(pieces), []
    while left:
        sequence.append(next(piece for piece in left if waits[piece].isdisjoint(left)))
        left.remove(sequence[-1])
    return sequence, ()


def _choices(candidates: Sequence[Sequence[Candidate]], repeats: bool) -> list[Choice]:
    if len(candidates) == 1:
        return [Choice((candidate,), repeats) for candidate in candidates[0]]
    sections = {candidate.section for candidate in candidates[0]}
    choices: list[Choice] = []
    for section in sorted(sections):
        here = [[way for way in ways if way.section == section] for ways in candidates]
        choices += [Choice(members, repeats) for members in product(*here)][:MOST_CHOICES]
    return choices
