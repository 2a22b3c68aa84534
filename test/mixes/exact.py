"""The same line as a model for CP-SAT, written from the rules and not from the planner."""

from __future__ import annotations

from typing import NamedTuple

from mixes.drawn import Mix
from ortools.sat.python import cp_model

LEADS, RESTS, TRAILS = range(3)
"""When an operation runs: before the belt rests, while it does, after it was released."""


class Exact(NamedTuple):
    """What is proven of the fastest plan, in milliseconds for each item."""

    least_ms: int
    most_ms: int


def solve(mix: Mix, limit_s: float) -> Exact:
    """Find the fastest plan, or bounds of it within a time."""
    line = _Line(mix)
    line.order()
    line.close()
    line.limit()
    solver = cp_model.CpSolver()
    solver.parameters.num_workers = 1
    solver.parameters.max_time_in_seconds = limit_s
    if solver.solve(line.model) not in {cp_model.OPTIMAL, cp_model.FEASIBLE}:
        raise RuntimeError(f'{mix.name}: CP-SAT finds nothing')
    return Exact(round(solver.best_objective_bound), round(solver.objective_value))


class _Line:
    def __init__(self, mix: Mix) -> None:
        self.model = model = cp_model.CpModel()
        self._mix = mix
        self._last = len(mix.ways) - 1
        self._done = [{way.section: model.new_bool_var('') for way in ways} for ways in mix.ways]
        self._section = [model.new_int_var(1, mix.sections, '') for _ in mix.ways]
        self._states = [[model.new_bool_var('') for _ in range(3)] for _ in mix.ways]
        self._together: dict[tuple[int, int], cp_model.IntVar] = {}
        for done, section in zip(self._done, self._section, strict=True):
            model.add_exactly_one(done.values())
            model.add(section == sum(number * literal for number, literal in done.items()))
        for ways, states in zip(mix.ways, self._states, strict=True):
            model.add_exactly_one(states)
            if ways[0].needs_belt:
                model.add(states[RESTS] == 1)

    @property
    def _pairs(self) -> set[tuple[int, int]]:
        """What comes before what: what needs the belt comes before the item leaves."""
        belt = {n for n, ways in enumerate(self._mix.ways) if ways[0].needs_belt}
        written = {(early, n) for n, before in enumerate(self._mix.before) for early in before}
        return written | {(task, self._last) for task in belt - {self._last}}

    def order(self) -> None:
        """Items move down the belt only, and each section has leads, then rests, then trails."""
        model, states = self.model, self._states
        for number in range(self._last):
            model.add(self._section[number] <= self._section[self._last])
            model.add(self._section[0] <= self._section[number])
        for first, second in sorted(self._pairs):
            here = self._together[first, second] = model.new_bool_var('')
            model.add(self._section[first] == self._section[second]).only_enforce_if(here)
            model.add(self._section[first] < self._section[second]).only_enforce_if(~here)
            model.add_bool_or(~here, ~states[second][LEADS], states[first][LEADS])
            model.add_implication(states[first][TRAILS], here)
            model.add_implication(states[first][TRAILS], states[second][TRAILS])

    def close(self) -> None:
        """Something trails only behind a task that needs the belt and comes last of what rests."""
        model, ways = self.model, self._mix.ways
        closing: dict[int, list[cp_model.IntVar]] = {}
        for number in (n for n, some in enumerate(ways) if some[0].needs_belt):
            for section, done in self._done[number].items():
                closes = model.new_bool_var('')
                closing.setdefault(section, []).append(closes)
                model.add_implication(closes, done)
                for first, second in self._pairs:
                    if first == number:
                        trails = self._states[second][TRAILS]
                        model.add_bool_or(~closes, ~self._together[first, second], trails)
        for done, states in zip(self._done, self._states, strict=True):
            for section, literal in done.items():
                model.add_bool_or(~literal, ~states[TRAILS], *closing.get(section, []))

    def limit(self) -> None:
        """Minimise the time of the longest section."""
        model, mix = self.model, self._mix
        most = sum(max(way.ms for way in ways) for ways in mix.ways) + mix.move_ms
        time = model.new_int_var(mix.move_ms, most, 'time')
        for section in range(1, mix.sections + 1):
            whole, turn = [], []
            for ways, done, states in zip(mix.ways, self._done, self._states, strict=True):
                for way in (option for option in ways if option.section == section):
                    rests = model.new_bool_var('')
                    model.add_bool_or(rests, ~done[section], ~states[RESTS])
                    whole.append(way.ms * done[section])
                    turn.append(way.ms * rests)
            model.add(sum(whole) <= time)
            model.add(sum(turn) + mix.move_ms <= time)
        model.minimize(time)
