"""A drawn line: its files as plain data, as YAML would say them, and what happens to it."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from hypothesis import strategies as st

Row = dict[str, Any]
Draw = st.DrawFn

MOST_SECTIONS = 8


@dataclass(frozen=True)
class Moment:
    """What an operator does after a while, if there is something to do."""

    delay_s: float
    choice: int


class Order(NamedTuple):
    """A work order."""

    id: str
    script: str
    quantity: int
    priority: int = 0
    start: float | None = None
    """Seconds from the begin of the run."""
    by_recipe: bool = False
    """It names a recipe, so what has not begun can be queued anew (7.6)."""
    setup: float = 0.0
    """Its parameter, which initialization may have as an argument."""


class Change(NamedTuple):
    """What an operator makes of an order."""

    quantity: int
    priority: int = 0
    start: float | None = None
    """Another one; None: as it was."""
    script: bool = False
    """Another script, by the number that is drawn."""


UPDATES = (
    Change(2),
    Change(1, 5),
    Change(3, -1, 30.0437),
    Change(1, script=True),
    Change(4, 3),
    Change(2, 0, 70.0211, script=True),
)


@dataclass(frozen=True)
class Plan:
    """A cell with its work and its bad luck."""

    cell: Row
    scripts: tuple[Row, ...]
    orders: tuple[Order, ...]
    later: tuple[Order, ...]
    """Orders that an operator gives in the course of things."""
    moments: tuple[Moment, ...]
    seconds: tuple[float, ...]
    """Durations of the goals of each component in turn; empty: the nominal ones."""
    rebuilds: frozenset[int]
    """Settles after which the tree is compiled anew."""

    @property
    def has_faults(self) -> bool:
        return any(device.get('faults') for device in devices(self.cell))

    def without_faults(self) -> Plan:
        """Return the same line, in which nothing goes wrong."""
        cell = copy.deepcopy(self.cell)
        for device in devices(cell):
            device['faults'] = []
        scripts = copy.deepcopy(self.scripts)
        for script in scripts:
            for listed in script['sections'].values():
                for task in tasks_of(listed['tasks'] if isinstance(listed, dict) else listed):
                    if 'fails_unless' in task:  # a repeat has to have one
                        own = f'${{results.{task["id"]}.item_present}}'
                        task['fails_unless'] = {'value': own, 'one_of': [True, False]}
                    task.pop('identifies', None)
        return replace(self, cell=cell, scripts=scripts)

    def without_flags(self, scripts: AbstractSet[str]) -> Plan:
        """Return the same line, in which these scripts have no flags."""
        kept = copy.deepcopy(self.scripts)
        for script in kept:
            if script['script'] in scripts:
                script.pop('lateral_dependencies', None)
        return replace(self, scripts=kept)

    def duration(self, component: str, nth: int) -> float | None:
        """Return the seconds of a component's nth goal; None: nominal."""
        if not self.seconds:
            return None
        return self.seconds[(nth + sum(map(ord, component))) % len(self.seconds)]


@dataclass(frozen=True)
class Traits:
    """What the lines of a property may have."""

    shared: bool = True
    """Shared components and zones."""
    faults: bool = True
    tied: bool = True
    """Durations may be equal, so that several things happen at one moment."""
    most_sections: int = MOST_SECTIONS
    short: bool = False
    """Several orders of one item, each with a setup of its own."""
    setups: bool = False
    """Components have setups, and tasks ask for values of them."""
    rejects: bool = False
    """Many items are rejected, and limits of rejects hold the line."""
    pieces: bool = False
    """Scripts ask for approvals of first pieces."""


def devices(cell: Row) -> list[Row]:
    """Return the conveyor and the components of a cell."""
    return [cell['conveyor'], *cell['components'].values()]


def chance(draw: Draw, percent: int) -> bool:
    """Draw true so often; false is simpler."""
    return draw(st.integers(0, 99)) >= 100 - percent


def tasks_of(steps: Sequence[Any]) -> list[Row]:
    """Return the tasks of steps, those of groups and their lists too."""
    tasks: list[Row] = []
    for step in steps:
        members = step.get('parallel', [step])
        for member in members:
            tasks += member if isinstance(member, list) else member.get('repeat', [member])
    return tasks
