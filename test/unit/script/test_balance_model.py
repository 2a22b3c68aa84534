"""The balance checks against a model that lets items fail in every possible way."""

from __future__ import annotations

import random
from itertools import product
from typing import NamedTuple

from fakes.script_texts import mistakes, script


class Line(NamedTuple):
    """Tasks behind the one that places the item, in the order in which the item meets them."""

    sections: tuple[tuple[str, ...], ...]

    @property
    def tasks(self) -> list[str]:
        return [task for section in self.sections for task in section]

    @property
    def text(self) -> str:
        lines = ['script: test', 'sections:']
        for number, tasks in enumerate(self.sections, 1):
            placing = ['{id: place, task: RUN, action: /lamp/task, qty_change: 1}']
            rest = [f'{{task: RUN, action: /lamp/task, {task}}}' for task in tasks]
            lines.append(f'  {number}: [{", ".join((placing if number == 1 else []) + rest)}]')
        return '\n'.join(lines)


OPTIONS = [
    f'qty_change: {quantity}, runs_for: {state}, on_failure: {policy}'
    for quantity, state, policy in product(
        ('0', '0', '-1'), ('good', 'good', 'rejected', 'all'), ('hold', 'hold', 'reject')
    )
]


def is_left_behind(tasks: list[str]) -> bool:
    """Tell whether some choice of failing tasks leaves a placed item on the belt.

    An operator may have rejected the item before; what only that leaves behind does not count.
    """
    rejecting = [number for number, task in enumerate(tasks) if 'on_failure: reject' in task]
    return any(
        is_left_by(
            tasks, {n for n, fails in zip(rejecting, choice, strict=True) if fails}, by_hand
        )
        for choice in product((False, True), repeat=len(rejecting))
        for by_hand in (None, *range(len(tasks)))
    )


def is_left_by(tasks: list[str], failing: set[int], by_hand: int | None) -> bool:
    rejected = False
    by_script = by_hand is None
    for number, task in enumerate(tasks):
        rejected = rejected or number == by_hand
        state = 'rejected' if rejected else 'good'
        if f'runs_for: {state}' not in task and 'runs_for: all' not in task:
            continue
        is_taking = 'qty_change: -1' in task
        if number in failing:
            by_script = by_script or not rejected or is_taking
            rejected = True
        elif is_taking:
            return False
    return by_script


def random_line(chance: random.Random) -> Line:
    lengths = [chance.randint(0, 2), *(chance.randint(1, 2) for _ in range(chance.randint(0, 2)))]
    return Line(tuple(tuple(chance.choices(OPTIONS, k=length)) for length in lengths))


def test_check_reports_exactly_the_items_left_behind() -> None:
    chance = random.Random(1)
    accepted = left = 0
    for _ in range(1500):
        line = random_line(chance)
        findings = mistakes(lambda: script(line.text))  # noqa: B023 - called at once
        if not findings:
            accepted += 1
            assert not is_left_behind(line.tasks), line.text
        elif any(
            words in finding
            for finding in findings
            for words in ('never taken out', 'no task takes', 'only rejected items')
        ):
            left += 1
            assert is_left_behind(line.tasks), (line.text, findings)
    assert accepted > 50
    assert left > 500
