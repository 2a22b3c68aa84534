"""The precedence graph of a recipe: what must be done before what, and why."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from bt_orchestrator.extensions.recipes.planning.candidates import Candidate, named_results
from bt_orchestrator.model.recipe import Overrides, Recipe


@dataclass(frozen=True)
class Ends:
    """Where an item comes onto the belt and leaves it."""

    places: str
    """The operation with `qty_change: 1`."""
    takes: tuple[str, ...]
    """Those with `qty_change: -1`."""
    takes_good: str
    """The one of them that good items meet."""
    all_leave_by: str = ''
    """It takes rejected items out as well, because something rejects and nothing else does."""


def ends(candidates: Mapping[str, Sequence[Candidate]]) -> tuple[Ends | None, list[str]]:
    """Find the ends of the line, or say why there are none."""
    changes = {name: {way.qty_change for way in ways} for name, ways in candidates.items()}
    faults = [
        f'`{name}` changes the number of items with one component, and not with another one'
        for name, amounts in changes.items()
        if len(amounts) > 1
    ]
    places = [name for name, amounts in changes.items() if amounts == {1}]
    takes = [name for name, amounts in changes.items() if amounts == {-1}]
    good = [name for name in takes if _runs_for(candidates[name], rejected=False)]
    if not places:
        faults.append('no operation places the item on the belt')
    if len(places) > 1:
        faults.append(f'{len(places)} operations place the item: {quoted(places)}')
    if not good:
        faults.append('no operation takes good items out')
    if len(good) > 1:
        faults.append(f'{len(good)} operations take a good item out: {quoted(good)}')
    if faults:
        return None, faults
    rejecting = any(way.may_reject for ways in candidates.values() for way in ways)
    is_taken = any(_runs_for(candidates[name], rejected=True) for name in takes)
    widened = good[0] if rejecting and not is_taken else ''
    return Ends(places[0], tuple(takes), good[0], widened), []


def _runs_for(ways: Sequence[Candidate], *, rejected: bool) -> bool:
    return any(way.runs_for.includes(rejected) for way in ways)


def quoted(names: Iterable[str]) -> str:
    """Return ids as messages name them."""
    return ', '.join(f'`{name}`' for name in names)


class Order:
    """The order of operations, for one item."""

    def __init__(
        self,
        recipe: Recipe,
        overrides: Overrides,
        candidates: Mapping[str, Sequence[Candidate]],
        line: Ends,
    ) -> None:
        self._line = line
        self._candidates = candidates
        self.before: dict[str, set[str]] = {operation.id: set() for operation in recipe.operations}
        """The operations directly before each one."""
        for before, after in _written(recipe, overrides):
            if before in self.before and after in self.before and before != after:
                self.before[after].add(before)
        self._leave_last()

    def _leave_last(self) -> None:
        """Put what needs the item, and is not written to come later, before its end."""
        line = self._line
        behind = {name for name in self.before if line.takes_good in self.all_before(name)}
        others = {*filter(self._needs_item, self.before)} - behind - {*line.takes}
        self.before[line.takes_good] |= others
        for taker in line.takes:
            if line.places not in self.all_before(taker):
                self.before[taker].add(line.places)
            for name in self._rejecting:
                if taker in self._take_rejected and taker not in {name, *self.all_before(name)}:
                    self.before[taker].add(name)

    @property
    def faults(self) -> Iterator[str]:
        """Yield which rejected items would stay on the belt, or be taken out twice."""
        early = {self._line.places, *self.all_before(self._line.places)}
        for name in self._rejecting:
            if name in early:
                continue
            before = {name, *self.all_before(name)}
            behind = [taker for taker in self._take_rejected if taker not in before]
            if not behind:
                yield f'an item that `{name}` rejects is never taken out'
            if len(behind) > 1:
                yield f'an item that `{name}` rejects is taken out twice, by {quoted(behind)}'

    def _needs_item(self, name: str) -> bool:
        return any(
            candidate.needs_belt or candidate.may_reject for candidate in self._candidates[name]
        )

    @property
    def _rejecting(self) -> list[str]:
        can = self._candidates
        return [
            name for name in self.before if any(candidate.may_reject for candidate in can[name])
        ]

    @property
    def _take_rejected(self) -> list[str]:
        if self._line.all_leave_by:
            return [self._line.all_leave_by]
        can = self._candidates
        return [name for name in self._line.takes if _runs_for(can[name], rejected=True)]

    def all_before(self, name: str) -> set[str]:
        """Return everything that comes before an operation, directly or not."""
        names: set[str] = set()
        open_ends = [name]
        while open_ends:
            new = self.before[open_ends.pop()] - names
            names |= new
            open_ends += new
        return names


def _written(recipe: Recipe, overrides: Overrides) -> Iterator[tuple[str, str]]:
    for operation in recipe.operations:
        for before in operation.after:
            yield before, operation.id
        for giver in operation.needs.values():
            yield giver, operation.id
        for giver, _ in named_results(operation, overrides):
            yield giver, operation.id
    for listed in overrides.order:
        yield from pairwise(listed)
    for rework in recipe.reworks:
        yield from pairwise(rework.operations)
