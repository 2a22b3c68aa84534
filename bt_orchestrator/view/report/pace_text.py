"""The pace of scripts as text for a person, and as plain data (semantics 8.4)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from bt_orchestrator.base.errors import counted
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.proof.pace import NAMED, Limit, Pace, PacedLine
from bt_orchestrator.model.proof.quicker import Quicker, Roomier, quicker, roomier
from bt_orchestrator.model.script import INDEX, Script
from bt_orchestrator.view.report.rates import Rate


@dataclass(frozen=True)
class Expected:
    """The pace with what is likely: the mean of a virtual run in which it is drawn."""

    per_item_s: float
    sure_s: float
    """The true mean is within so much of it, with a probability of 95 %."""
    items: int
    """Items of the run, without those that fill the line and those that leave it."""
    good: float
    """Share of the items that left the line conforming."""
    holds: int
    """Failures that were held for a person, and answered at once."""
    rates: tuple[Rate, ...]
    """The rates of the draws."""
    always: tuple[str, ...]
    """Tasks with a condition without a rate: they ran for all items."""

    @property
    def per_good_s(self) -> float | None:
        """Seconds from one good item to the next; None: there was none."""
        return self.per_item_s / self.good if self.good else None

    def lines(self) -> Iterator[str]:
        """Yield it for a person."""
        good = '' if self.good == 1.0 else ', no good item'
        if good and self.per_good_s is not None:
            good = f', {self.per_good_s:.2f} s per good item'
        yield f'expected: {self.per_item_s:.2f} s per item (± {self.sure_s:.2f} s){good}'
        drawn = _named([str(rate) for rate in self.rates])
        yield f'  over {counted(self.items, "item")} in virtual time: {drawn}'
        if self.always:
            yield f'  no `likely`, so counted as always run: {_named(self.always)}'
        if self.holds:
            yield f'  {counted(self.holds, "hold")} answered at once: waiting is not counted'

    def plain(self) -> dict[str, Any]:
        """Return it as data that JSON can carry."""
        rates = [vars(rate) for rate in self.rates]
        return {
            **vars(self),
            'per_good_s': self.per_good_s,
            'rates': rates,
            'always': list(self.always),
        }


def _named(names: Sequence[str]) -> str:
    more = len(names) - NAMED
    return ', '.join([*names[:NAMED], *([f'{more} more'] if more > 0 else [])])


@dataclass(frozen=True)
class ScriptPace:
    """How fast a line makes what a script says, and what would make it faster."""

    script: str
    pace: Pace | None
    """None: the line gets stuck."""
    quicker: Quicker | None
    """None: no task limits it."""
    roomier: Roomier | None
    """None: no flag limits it, or none alone."""
    expected: Expected | None = None
    """None: nothing is known to be likely, or the line gets stuck."""

    def lines(self) -> Iterator[str]:
        """Yield it for a person."""
        if self.pace is not None:
            yield str(self.pace)
        yield from (str(gain) for gain in (self.quicker, self.roomier) if gain is not None)
        if self.expected is not None:
            yield from self.expected.lines()

    def plain(self) -> dict[str, Any]:
        """Return it as data that JSON can carry."""
        fields: dict[str, Any] = {'script': self.script, 'per_item_s': None}
        pace, saving, larger = self.pace, self.quicker, self.roomier
        if pace is not None:
            fields |= {
                'per_item_s': pace.per_item_s,
                'least_s': pace.least.per_item_s,
                'exact': pace.is_exact,
                'not_counted': list(pace.not_counted),
                'limit': _plain(pace.limit),
            }
        if saving is not None:
            fields['quicker'] = {
                'task': saving.task,
                'by_s': saving.by_s,
                **_then(saving.then),
            }
        if larger is not None:
            fields['roomier'] = {
                'flag': larger.flag,
                'capacity': larger.capacity,
                **_then(larger.then),
            }
        fields['expected'] = None if self.expected is None else self.expected.plain()
        return fields


def script_pace(script: Script, cell: Cell, expected: Expected | None = None) -> ScriptPace:
    """Return the pace of a script by the durations of a cell."""
    line = PacedLine(script, cell)
    return ScriptPace(
        script.name, line.pace(cell), quicker(line, cell), roomier(line, cell), expected
    )


def _then(limit: Limit) -> dict[str, Any]:
    return {'per_item_s': limit.per_item_s, 'limit': _plain(limit)}


def _plain(limit: Limit) -> dict[str, Any]:
    return {
        'words': str(limit),
        'tasks': [task for task in limit.tasks if task != INDEX],
        'belt_moves': INDEX in limit.tasks,
        'items': limit.items,
        'flags': list(limit.flags),
        'only_one': limit.only_one,
    }
