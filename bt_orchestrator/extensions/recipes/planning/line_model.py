"""The aim of the model of a line, and how it is solved: by stages, until the plan is unique."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from bt_orchestrator.extensions.recipes.planning.candidates import Candidate
from bt_orchestrator.extensions.recipes.planning.line_rows import LineRows
from bt_orchestrator.extensions.recipes.planning.outcome import NotFound
from bt_orchestrator.extensions.recipes.planning.scripts import Plan, Plans
from bt_orchestrator.extensions.recipes.planning.solver import Answer

_LESS = 5
"""So much less of the solver's tree is searched for what comes after the pace."""

_ROUNDS = 6
"""Plans that are asked who else could do something."""


@dataclass(frozen=True)
class Solution:
    """The best plan that a model has."""

    plan: Plan
    moved: int
    """Operations that are elsewhere than in the script that is kept."""
    us: int
    """The seconds for each item by the model; the script may take more."""
    bound_us: int
    """No plan of the model takes less time for each item."""
    spread_us: int
    """Work of all sections, where that above an even share counts twice."""
    is_spread_least: bool
    """No plan of the model that is as fast has less."""


class LineModel(LineRows):
    """The model of all plans."""

    def __init__(self, plans: Plans) -> None:
        super().__init__(plans)
        self._spread = self._spread_terms()

    # --- the aim ----------------------------------------------------------------------------

    def _spread_terms(self) -> Counter[int]:
        least = sum(min(way.us for way in ways) for ways in self._plans.choices)
        share = self._units(least) // len(self._here)
        terms = self._work(self._keys)
        for section in sorted(self._here):
            above = self._model.variable(self._most)
            work = self._work(self._here[section])
            self._model.at_most({above: -1, **work}, share)
            terms[above] = 1
        return terms

    def _moved_terms(self) -> dict[int, int]:
        moved = {self._chosen[p, n]: self._plans.moved[p][n] for p, n in self._keys}
        return {number: count for number, count in moved.items() if count}

    def _declared_terms(self) -> dict[int, int]:
        """Say how far choices are from those that were declared first; of earlier pieces more."""
        count = len(self._plans.choices)
        weight = count * len(self._keys)
        return {self._chosen[p, n]: n * (weight + count - p) for p, n in self._keys if n}

    # --- solving ----------------------------------------------------------------------------

    def best(self, nodes: int, question_nodes: int = 0) -> Solution | None:
        """Return the best plan, by stages; None: there is none.

        :param nodes: as in `Limits`, and so are those of questions
        :raises NotFound: none was found within this many nodes
        """
        size = self._model.size
        try:
            return self._staged(nodes, question_nodes)
        finally:
            self._model.forget(size)

    def _staged(self, nodes: int, question_nodes: int) -> Solution | None:
        stages = {
            'moved': self._moved_terms(),
            'time': {self._time: 1},
            'spread': self._spread,
            'declared': self._declared_terms(),
        }
        answers: dict[str, Answer] = {}
        last: Answer | None = None
        for name, cost in stages.items():
            if cost:
                if name == 'time' and question_nodes:
                    last = self._model.least(self._time, nodes, question_nodes, last)
                else:
                    limit = nodes if name in {'moved', 'time'} else nodes // _LESS
                    last = self._model.minimise(cost, limit, last)
                if last is None:
                    return None
                answers[name] = last
                self._model.at_most(cost, last.cost)
        assert last is not None
        plan = tuple(number for p, number in self._keys if last.values[self._chosen[p, number]])
        spread = answers['spread']
        return Solution(
            plan=plan,
            moved=sum(ways[number] for ways, number in zip(self._plans.moved, plan, strict=True)),
            us=answers['time'].cost * self._unit_us,
            bound_us=answers['time'].bound * self._unit_us,
            spread_us=spread.cost * self._unit_us,
            is_spread_least=spread.bound == spread.cost,
        )

    def elsewhere(
        self, asked: Mapping[str, Candidate], nodes: int, *, us: int, spread_us: int | None = None
    ) -> tuple[set[str], bool]:
        """Find which operations another component could do in a plan that is as good.

        :param asked: operations, and who does them
        :param us: microseconds for each item, at most
        :return: the operations, and whether it is proven that there are no others
        """
        size, names = self._model.size, set[str]()
        self._model.at_most({self._time: 1}, self._units(us))
        if spread_us is not None:
            self._model.at_most(self._spread, self._units(spread_us))
        away = {name: self._away(candidate) for name, candidate in asked.items()}
        cost = dict.fromkeys(away.values(), -1)
        for _ in range(_ROUNDS):
            try:
                answer = self._model.minimise(cost, nodes)
            except NotFound:
                answer = None
            new = {name for name, number in away.items() if answer and answer.values[number]}
            if new <= names:
                break
            names |= new
            cost = {number: -1 for name, number in away.items() if name not in names}
            if not cost:
                break
        self._model.forget(size)
        return names, not cost or (answer is not None and not answer.bound)

    def _away(self, candidate: Candidate) -> int:
        """Return a variable that is at most whether another component does an operation."""
        away = self._model.variable()
        others = self._by(candidate.operation.id, lambda name: name != candidate.component.name)
        self._model.at_most({away: 1, **dict.fromkeys(others, -1)}, 0)
        return away

    def bind(self, operation: str, component: str) -> None:
        """Let a component do an operation."""
        self._model.equal(dict.fromkeys(self._by(operation, component.__eq__), 1), 1)

    def _by(self, operation: str, fits: Callable[[str], bool]) -> list[int]:
        """Return what is chosen where a component that fits does an operation."""
        piece = self._plans.pieces.number_of[operation]
        return [
            self._chosen[key]
            for key in self._in(piece, bool)
            for member in self._choice(key).members
            if member.operation.id == operation and fits(member.component.name)
        ]

    @property
    def is_exact(self) -> bool:
        """Tell whether what the model says of a plan is no bound, but its pace."""
        choices = [self._choice(key) for key in self._keys]
        return (
            not self._plans.shared
            and not self._plans.held
            and all(choice.is_alone for choice in choices)
        )

    def exclude(self, plan: Plan) -> None:
        """Leave a plan out from now on."""
        terms = {self._chosen[key]: 1 for key in enumerate(plan)}
        self._model.at_most(terms, len(plan) - 1)
