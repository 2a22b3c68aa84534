"""Mixed-integer models in whole numbers, solved by HiGHS: the only file that knows it.

One thread, one seed, no gap, and a limit of nodes, never of time: equal models give equal answers.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import ModuleType
from typing import TYPE_CHECKING

from bt_orchestrator.extensions.recipes.planning.outcome import NotFound

if TYPE_CHECKING:
    import highspy

Terms = Mapping[int, int]
"""Coefficients, by the number of the variable."""

Row = tuple[Terms, float, float]
"""The sum of the terms is at least this, and at most that."""

VERSION = '1.16.0'
"""Another release of HiGHS may choose another one of equally good plans."""

_OPTIONS = {
    'output_flag': False,
    'threads': 1,
    'random_seed': 0,
    'mip_rel_gap': 0.0,
    'mip_abs_gap': 0.0,
}
_ROUNDING = 1e-5
_SHORT = 5
"""A short search has so much fewer nodes."""
_MORE = 2
"""A question in steps has so many times the nodes."""


@dataclass(frozen=True)
class Answer:
    """The best values that were found."""

    values: Sequence[int]
    cost: int
    bound: int
    """Every solution costs at least this much."""


@dataclass
class Model:
    """Variables that are whole numbers, and linear rows over them."""

    _most: list[int] = field(default_factory=list)
    _rows: list[Row] = field(default_factory=list)
    _earlier: dict[int, int] = field(default_factory=dict)
    """By variable of a choice: the variable before it."""

    def variable(self, most: int = 1) -> int:
        """Add a variable from 0 to `most`, and return its number."""
        self._most.append(most)
        return len(self._most) - 1

    def at_most(self, terms: Terms, most: int) -> None:
        """Add a row: the sum of the terms is at most this."""
        self._rows.append((terms, -math.inf, most))

    def at_least(self, terms: Terms, least: int) -> None:
        """Add a row: the sum of the terms is at least this."""
        self._rows.append((terms, least, math.inf))

    def equal(self, terms: Terms, value: int) -> None:
        """Add a row: the sum of the terms is this."""
        self._rows.append((terms, value, value))

    def one_of(self, variables: Sequence[int]) -> None:
        """Add a row: one of these is 1. They are in an order in which they can be halved."""
        self.equal(dict.fromkeys(sorted(variables), 1), 1)
        self._earlier.update(zip(variables[1:], variables, strict=False))

    @property
    def size(self) -> int:
        """The number of rows."""
        return len(self._rows)

    def forget(self, size: int) -> None:
        """Remove the rows that were added since the model had this many."""
        del self._rows[size:]

    def minimise(self, cost: Terms, nodes: int, begin: Answer | None = None) -> Answer | None:
        """Return the values with the least cost; None: the rows contradict each other.

        :param nodes: of the tree that may be searched
        :param begin: values that meet all rows
        :raises NotFound: no solution was found within this many nodes, or HiGHS is not installed
        """
        highs = _highs()
        solver = self._solver(highs, cost, nodes)
        if begin is not None:
            known = highs.HighsSolution()
            known.col_value = [float(value) for value in begin.values]
            solver.setSolution(known)
        solver.run()
        status = solver.getModelStatus()
        if status == highs.HighsModelStatus.kInfeasible:
            return None
        values = [round(value) for value in solver.getSolution().col_value]
        if not self._is_met(values) and begin is not None:
            values = list(begin.values)
        elif not self._is_met(values):
            raise NotFound([f'not found within {nodes:,} nodes; not proven impossible'])
        total = sum(values[number] * factor for number, factor in cost.items())
        if status == highs.HighsModelStatus.kOptimal:
            return Answer(values, total, total)
        bound = solver.getInfo().mip_dual_bound
        least = math.ceil(bound - _ROUNDING) if math.isfinite(bound) else -(10**15)
        return Answer(values, total, min(least, total))

    def least(
        self, variable: int, nodes: int, question_nodes: int, begin: Answer | None = None
    ) -> Answer | None:
        """Return values with which a variable is least; None: the rows contradict each other.

        Where the variable is what no sum of some rows may exceed, a search for its least value
        bounds it badly. Whether it can be at most a fixed number is answered far sooner: the rows
        are knapsacks then. So such questions halve what a short search leaves open. From the
        first one without an answer on, they are asked in steps.

        :param nodes: of the tree of the search, which is short where it finds values
        :param question_nodes: of the tree of each question, which take less time
        :param begin: values that meet all rows
        :raises NotFound: no solution was found within this many nodes, or HiGHS is not installed
        """
        try:
            best = self.minimise({variable: 1}, nodes // _SHORT, begin)
        except NotFound:
            best = self.minimise({variable: 1}, nodes, begin)
        if best is None:
            return None
        bound = low = best.bound
        in_steps = False
        while low < best.cost:
            middle = (low + best.cost) // 2
            try:
                answer = self._asked(variable, middle, question_nodes, in_steps=in_steps)
            except NotFound:
                if in_steps:
                    low = middle + 1  # that stays open
                in_steps = True
            else:
                if answer is None:
                    bound = low = middle + 1
                else:
                    best = replace(answer, cost=answer.values[variable])
        return replace(best, bound=bound)

    def _asked(self, variable: int, most: int, nodes: int, *, in_steps: bool) -> Answer | None:
        """Return values with which a variable is at most this; None: there are none."""
        size = self.size
        self.at_most({variable: 1}, most)
        try:
            if not in_steps:
                return self.minimise({}, nodes)
            answer = self._in_steps().minimise({}, nodes * _MORE)
        finally:
            self.forget(size)
        return answer and replace(answer, values=self._out_of_steps(answer.values))

    def _in_steps(self) -> Model:
        """Return it in steps: each tells whether its variable or an earlier one is 1.

        A tree of steps is smaller: a branch leaves about half of what can be chosen.
        """
        rows: list[Row] = []
        for terms, least, most in self._rows:
            steps = Counter(terms)
            for number, factor in terms.items():
                if number in self._earlier:
                    steps[self._earlier[number]] -= factor
            rows.append(({n: factor for n, factor in steps.items() if factor}, least, most))
        rows += [({early: 1, late: -1}, -math.inf, 0) for late, early in self._earlier.items()]
        return Model(self._most, rows)

    def _out_of_steps(self, steps: Sequence[int]) -> Sequence[int]:
        return [
            step - steps[self._earlier[number]] if number in self._earlier else step
            for number, step in enumerate(steps)
        ]

    def _is_met(self, values: Sequence[int]) -> bool:
        """Judge values in whole numbers: the solver works with rounding errors."""
        return len(values) == len(self._most) and all(
            least <= sum(values[number] * factor for number, factor in terms.items()) <= most
            for terms, least, most in self._rows
        )

    def _solver(self, highs: ModuleType, cost: Terms, nodes: int) -> highspy.Highs:
        import numpy as np

        program, count = highs.HighsLp(), len(self._most)
        program.num_col_, program.num_row_ = count, len(self._rows)
        program.col_cost_ = np.array([cost.get(number, 0) for number in range(count)], float)
        program.col_lower_ = np.zeros(count)
        program.col_upper_ = np.array(self._most, float)
        program.row_lower_ = np.array([least for _, least, _ in self._rows], float)
        program.row_upper_ = np.array([most for _, _, most in self._rows], float)
        matrix, terms = program.a_matrix_, [terms for terms, _, _ in self._rows]
        matrix.format_ = highs.MatrixFormat.kRowwise
        matrix.start_ = np.cumsum([0, *map(len, terms)])
        matrix.index_ = np.array([number for row in terms for number in row])
        matrix.value_ = np.array([factor for row in terms for factor in row.values()], float)
        program.integrality_ = [highs.HighsVarType.kInteger] * count
        silent = type('Silent', (highs.Highs,), {'enableCallbacks': lambda _: None})  # a banner
        solver: highspy.Highs = silent()
        for name, value in _OPTIONS.items():
            solver.setOptionValue(name, value)
        solver.setOptionValue('mip_max_nodes', nodes)
        solver.passModel(program)
        return solver


def _highs() -> ModuleType:
    """Return the module of HiGHS, which is imported when something is planned."""
    try:
        import highspy
    except ImportError as error:
        how = f"install it with: pip install 'highspy=={VERSION}'"
        raise NotFound([f'planning needs HiGHS, which cannot be imported; {how}']) from error
    return highspy
