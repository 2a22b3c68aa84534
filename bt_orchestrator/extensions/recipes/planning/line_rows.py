"""A line as a mixed-integer model: who does what in which section, what leads and what trails.

Time is counted in the greatest unit that all durations are whole multiples of. What the model
says of a plan is exact where sections share nothing, nothing runs side by side in a section, and
no device keeps anything; elsewhere it is a bound: no script of this plan is faster.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Mapping

from bt_orchestrator.extensions.recipes.planning.pieces import Choice
from bt_orchestrator.extensions.recipes.planning.scripts import Plans
from bt_orchestrator.extensions.recipes.planning.solver import Model
from bt_orchestrator.model.cell import CONVEYOR

Key = tuple[int, int]
"""A piece, and the number of its choice."""


class LineRows:
    """The rows of the model of all plans."""

    def __init__(self, plans: Plans) -> None:
        self._plans = plans
        self._model = model = Model()
        self._keys = [(p, n) for p, ways in enumerate(plans.choices) for n in range(len(ways))]
        self._chosen = {key: model.variable() for key in self._keys}
        self._here: dict[int, list[Key]] = defaultdict(list)
        for key in self._keys:
            self._here[self._choice(key).section].append(key)
        times = [member.us for key in self._keys for member in self._choice(key).members]
        self._unit_us = math.gcd(plans.move_us, *times) or 1
        self._most = self._units(plans.move_us + sum(times))
        self._time = model.variable(self._most)
        self._rests: list[int] = []
        """By section in which all can be done: whether it is, and so the belt never moves."""
        self._place()
        self._move()
        self._leading: dict[Key, int] = {}
        self._trailing: dict[Key, int] = {}
        self._lead()
        self._trail()
        for section in sorted(self._here):
            self._last(self._here[section])
        self._limit()
        self._keep()

    def _choice(self, key: Key) -> Choice:
        return self._plans.choices[key[0]][key[1]]

    def _units(self, us: int) -> int:
        return us // self._unit_us

    def _in(self, piece: int, fits: Callable[[Choice], bool]) -> list[Key]:
        ways = self._plans.choices[piece]
        return [(piece, number) for number, choice in enumerate(ways) if fits(choice)]

    def _beside(self, piece: int, section: int) -> list[Key]:
        return self._in(piece, lambda choice: choice.section == section)

    # --- what is possible -------------------------------------------------------------------

    def _place(self) -> None:
        """Choose once for each piece, and let items move down the belt only."""
        ways = self._plans.choices
        for piece in range(len(ways)):
            along = sorted(self._in(piece, bool), key=lambda key: self._choice(key).section)
            self._model.one_of([self._chosen[key] for key in along])
        for first, second in dict.fromkeys(
            (link.first, link.second) for link in self._plans.reach.links
        ):
            for section in sorted({choice.section for choice in ways[second]}):
                self._none_before(first, second, section)

    def _none_before(self, first: int, second: int, section: int) -> None:
        """A piece that is done up to a section has all earlier pieces done up to there."""
        late = {self._chosen[key]: 1 for key in self._in(first, lambda c: c.section > section)}
        done = {self._chosen[key]: 1 for key in self._in(second, lambda c: c.section <= section)}
        if late:
            self._model.at_most({**late, **done}, 1)

    def _keep(self) -> None:
        """A device keeps one thing for one operation, as far as it has room, in no repeat."""
        givers: dict[tuple[str, str], list[int]] = defaultdict(list)
        number_of = self._plans.pieces.number_of
        for held in self._plans.held:
            giver = number_of[held.giver]
            for key in self._in(giver, bool):
                choice = self._choice(key)
                for member in filter(held.is_kept_by, choice.members):
                    givers[member.component.name, held.name].append(self._chosen[key])
                    room = choice.section + member.capability.holds[held.name]
                    far = [
                        self._chosen[other]
                        for taker in held.takers
                        for other in self._in(number_of[taker], bool)
                        if self._choice(other).section > room or self._choice(other).repeats
                    ]
                    if choice.repeats:
                        self._model.at_most({self._chosen[key]: 1}, 0)
                    for variable in far:
                        self._model.at_most({self._chosen[key]: 1, variable: 1}, 1)
        for keepers in givers.values():
            self._model.at_most(Counter(keepers), 1)

    # --- lists ------------------------------------------------------------------------------

    def _lead(self) -> None:
        """A piece without the belt leads if all pieces before it in its section do."""
        model, before = self._model, self._plans.pieces.before
        for key in self._keys:
            choice = self._choice(key)
            if choice.needs_belt:
                continue
            lead = self._leading[key] = model.variable()
            model.at_most({lead: 1, self._chosen[key]: -1}, 0)
            for other in before[key[0]]:
                terms = {lead: 1}
                for other_key in self._beside(other, choice.section):
                    terms[self._chosen[other_key]] = 1
                    if other_key in self._leading:
                        terms[self._leading[other_key]] = -1
                if len(terms) > 1:
                    model.at_most(terms, 1)

    def _trail(self) -> None:
        """A piece without the belt that cannot reject trails if all pieces behind it do."""
        model, behind = self._model, self._plans.pieces.behind
        for key in reversed(self._keys):
            choice = self._choice(key)
            with_it = [
                [
                    self._trailing[other_key]
                    for other_key in self._beside(other, choice.section)
                    if other_key in self._trailing
                ]
                for other in behind[key[0]]
            ]
            if choice.needs_belt or choice.may_reject or not all(with_it):
                continue
            trail = self._trailing[key] = model.variable()
            model.at_most({trail: 1, self._leading[key]: 1, self._chosen[key]: -1}, 0)
            for others in with_it:
                model.at_most({trail: 1, **dict.fromkeys(others, -1)}, 0)

    def _last(self, here: list[Key]) -> None:
        """Something trails only if what is last before it needs the belt."""
        trails = [self._trailing[key] for key in here if key in self._trailing]
        if not trails:
            return
        model, section = self._model, self._choice(here[0]).section
        closings = {}
        for key in here:
            if not self._choice(key).needs_belt:
                continue
            closing = closings[key] = model.variable()
            model.at_most({closing: 1, self._chosen[key]: -1}, 0)
            for other in self._plans.pieces.behind[key[0]]:
                terms = {closing: 1}
                for other_key in self._beside(other, section):
                    terms[self._chosen[other_key]] = 1
                    if other_key in self._trailing:
                        terms[self._trailing[other_key]] = -1
                model.at_most(terms, 1)
        for trail in trails:
            model.at_most({trail: 1, **dict.fromkeys(closings.values(), -1)}, 0)

    # --- time -------------------------------------------------------------------------------

    def _move(self) -> None:
        """The belt moves once for each item, unless all is done in one section."""
        common = set.intersection(*map(set, self._plans.reach.sections))
        self._rests = [self._rests_in(section) for section in sorted(common)]
        self._model.at_most(dict.fromkeys(self._rests, 1), 1)
        self._at_least_time({}, moves=True)

    def _rests_in(self, section: int) -> int:
        alone = self._model.variable()
        for piece in range(len(self._plans.choices)):
            here = {self._chosen[key]: -1 for key in self._beside(piece, section)}
            self._model.at_most({alone: 1, **here}, 0)
        return alone

    def _at_least_time(self, work: Mapping[int, int], *, moves: bool) -> None:
        """The time of an item is at least this work, with the move of the belt."""
        move = self._units(self._plans.move_us) if moves else 0
        terms = {self._time: 1, **{number: -units for number, units in work.items() if units}}
        if move:
            terms.update(dict.fromkeys(self._rests, move))
        self._model.at_least(terms, move)

    def _limit(self) -> None:
        for section in sorted(self._here):
            for keys in self._in_a_row(self._here[section]):
                self._at_least_time(self._work(keys), moves=False)
                middle = self._work(keys)
                for parts in (self._leading, self._trailing):
                    for key in keys:
                        if key in parts:
                            middle[parts[key]] = -self._units(self._choice(key).us)
                self._at_least_time(middle, moves=True)
        for name in self._plans.shared:
            work: Counter[int] = Counter()
            for key in self._keys:
                for member in self._choice(key).members:
                    if name in member.spaces:
                        work[self._chosen[key]] += self._units(member.us)
            self._at_least_time(work, moves=name == CONVEYOR)

    def _in_a_row(self, here: list[Key]) -> Iterator[list[Key]]:
        """Yield choices of a section that cannot run side by side, two by two."""
        alone = [key for key in here if self._choice(key).is_alone]
        others = [key for key in here if not self._choice(key).is_alone]
        spaces = sorted({name for key in others for name in self._choice(key).spaces})
        for name in spaces or ['']:
            yield [*alone, *(key for key in others if name in self._choice(key).spaces)]

    def _work(self, keys: list[Key]) -> Counter[int]:
        return Counter({self._chosen[key]: self._units(self._choice(key).us) for key in keys})
