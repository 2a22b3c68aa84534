"""Recipes of any size whose fastest script is known: every section has the same work in it.

Each operation is drawn into a section, in which its durations fill the beat exactly; its other
candidates are in neighbouring sections and take as long, or longer. So no script is faster than
the one that was drawn, which the planner does not see.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from random import Random

from bt_orchestrator.model.cell import Capability, Cell, Component, Conveyor
from bt_orchestrator.model.recipe import Operation, Recipe

TYPE = 'bt_orchestrator_interfaces/action/Component'
BELT_TYPE = 'bt_orchestrator_interfaces/action/Conveyor'
MOVE_S = 2.0
BEAT_MS = 60_000
"""Work of each section for one item."""


@dataclass(frozen=True)
class DrawnLine:
    """A recipe, a cell, and how fast it can be made."""

    cell: Cell
    recipe: Recipe
    best_s: float


def drawn_line(
    seed: int, operations: int, *, candidates: int = 2, sections: int = 10
) -> DrawnLine:
    """Draw a line.

    :param operations: with the one that places items and the one that takes them out
    :param candidates: of each operation
    """
    random = Random(seed)
    homes = sorted(random.randrange(sections) for _ in range(operations - 2 * sections))
    homes = sorted([*homes, *range(sections), *range(sections)])
    parts = {n: list(_parts(random, homes.count(n))) for n in range(sections)}
    abilities: dict[int, dict[str, tuple[Capability, float]]] = {n: {} for n in range(sections)}
    listed = []
    for number, home in enumerate(homes):
        name = f'op{number}'
        ms = parts[home].pop()
        change = {0: 1, operations - 1: -1}.get(number, 0)
        others = [] if change else _others(random, home, sections, candidates - 1)
        for section in (home, *others):
            longer = 1.0 if section == home else random.choice((1.0, 1.0, 1.1, 1.3))
            options = {'qty_change': change} if change else {}
            can = Capability(name, name.upper(), options=options)
            abilities[section][name] = can, ms * longer / 1000
        before = max(0, number - random.randint(1, 10))
        listed.append(Operation(name, (name,), (f'op{before}',) if number else ()))
    components = {f'station{n + 1}': _station(n + 1, abilities[n]) for n in range(sections)}
    belt = Component('conveyor', (), '/belt', BELT_TYPE, durations_s={'MOVE_ONE_INDEX': MOVE_S})
    conveyor = Conveyor(sections, belt, 'MOVE_ONE_INDEX')
    cell = Cell('bench', conveyor, {'conveyor': belt, **components})
    return DrawnLine(cell, Recipe('bench', 1, 'bench', tuple(listed)), BEAT_MS / 1000 + MOVE_S)


def _parts(random: Random, count: int) -> Iterator[int]:
    """Part the work of a section."""
    cuts = sorted(random.sample(range(1, BEAT_MS // 500), count - 1))
    marks = [0, *(cut * 500 for cut in cuts), BEAT_MS]
    yield from (after - before for before, after in pairwise(marks))


def _others(random: Random, home: int, sections: int, count: int) -> list[int]:
    near = [n for n in range(home - 2, home + 3) if n != home and 0 <= n < sections]
    return random.sample(near, min(count, len(near)))


def _station(number: int, can: dict[str, tuple[Capability, float]]) -> Component:
    return Component(
        f'station{number}',
        (number,),
        f'/station{number}',
        TYPE,
        durations_s={name.upper(): seconds for name, (_, seconds) in can.items()},
        capabilities={name: capability for name, (capability, _) in can.items()},
    )
