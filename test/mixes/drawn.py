"""Lines of 10 to 60 operations with two to four candidates each, which share nothing."""

from __future__ import annotations

from dataclasses import dataclass
from random import Random
from typing import NamedTuple

from bt_orchestrator.model.cell import Capability, Cell, Component, Conveyor
from bt_orchestrator.model.recipe import Operation, Recipe

TYPE = 'bt_orchestrator_interfaces/action/Component'
BELT_TYPE = 'bt_orchestrator_interfaces/action/Conveyor'


class Way(NamedTuple):
    """One way to do an operation."""

    section: int
    ms: int
    needs_belt: bool


@dataclass(frozen=True)
class Mix:
    """A line as numbers, of which cell and recipe are made."""

    seed: int
    sections: int
    move_ms: int
    ways: tuple[tuple[Way, ...], ...]
    before: tuple[tuple[int, ...], ...]
    """Numbers of the operations directly before each one."""

    @property
    def name(self) -> str:
        """What it is called in the list."""
        candidates = max(map(len, self.ways))
        return f'mix {self.seed}: {len(self.ways)} operations with {candidates} candidates'

    @property
    def recipe(self) -> Recipe:
        """As a recipe."""
        names = [f'op{number}' for number in range(len(self.ways))]
        listed = [
            Operation(name, (name,), tuple(names[index] for index in before))
            for name, before in zip(names, self.before, strict=True)
        ]
        return Recipe('mix', 1, 'mix', tuple(listed))

    @property
    def cell(self) -> Cell:
        """As a cell with a station in each section."""
        able: dict[int, dict[str, tuple[Capability, float]]] = {}
        ends = {0: 1, len(self.ways) - 1: -1}
        for number, ways in enumerate(self.ways):
            for way in ways:
                options = {'requires_conveyor': way.needs_belt}
                change = {'qty_change': ends[number]} if number in ends else {}
                name = f'op{number}'
                can = Capability(name, name.upper(), options={**options, **change})
                able.setdefault(way.section, {})[name] = can, way.ms / 1000
        stations = {f's{n}': _station(n, can) for n, can in sorted(able.items())}
        durations_s = {'MOVE_ONE_INDEX': self.move_ms / 1000}
        belt = Component('conveyor', (), '/belt', BELT_TYPE, durations_s=durations_s)
        conveyor = Conveyor(self.sections, belt, 'MOVE_ONE_INDEX')
        return Cell('mixes', conveyor, {'conveyor': belt, **stations})


def _station(number: int, can: dict[str, tuple[Capability, float]]) -> Component:
    return Component(
        f's{number}',
        (number,),
        f'/s{number}',
        TYPE,
        durations_s={name.upper(): seconds for name, (_, seconds) in can.items()},
        capabilities={name: capability for name, (capability, _) in can.items()},
    )


def mix(seed: int) -> Mix:
    """Draw one."""
    random = Random(seed)
    count, candidates = random.choice((10, 15, 20, 30, 40, 60)), random.randint(2, 4)
    sections = max(3, count // random.randint(3, 7))
    ways, before = [], []
    for number in range(count):
        home, is_end = 1 + number * sections // count, number in {0, count - 1}
        near = [n for n in range(home - 2, home + 3) if n != home and 0 < n <= sections]
        others = [] if is_end else random.sample(near, min(len(near), candidates - 1))
        base = random.randint(5, 90) * 100
        is_free = not is_end and random.random() < 0.2
        ways.append(
            tuple(
                Way(section, round(base * random.choice((0.7, 1, 1, 1.2, 1.5))), not is_free)
                for section in sorted((home, *others))
            )
        )
        early = range(max(0, number - 10), number)
        before.append(tuple(random.sample(early, min(len(early), random.randint(1, 2)))))
    return Mix(seed, sections, random.choice((500, 2000)), tuple(ways), tuple(before))
