"""The pace of scripts as text for a person, and as plain data (semantics 8.4)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.proof.pace import Limit, Pace, PacedLine
from bt_orchestrator.model.proof.quicker import Quicker, Roomier, quicker, roomier
from bt_orchestrator.model.script import INDEX, Script


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

    def lines(self) -> Iterator[str]:
        """Yield it for a person."""
        if self.pace is not None:
            yield str(self.pace)
        yield from (str(one) for one in (self.quicker, self.roomier) if one is not None)

    def plain(self) -> dict[str, Any]:
        """Return it as data that JSON can carry."""
        found: dict[str, Any] = {'script': self.script, 'per_item_s': None}
        pace, saving, larger = self.pace, self.quicker, self.roomier
        if pace is not None:
            found |= {
                'per_item_s': pace.per_item_s,
                'least_s': pace.least.per_item_s,
                'exact': pace.is_exact,
                'not_counted': list(pace.not_counted),
                'limit': _plain(pace.limit),
            }
        if saving is not None:
            found['quicker'] = {
                'task': saving.task,
                'by_s': saving.by_s,
                **_then(saving.then),
            }
        if larger is not None:
            found['roomier'] = {
                'flag': larger.flag,
                'capacity': larger.capacity,
                **_then(larger.then),
            }
        return found


def script_pace(script: Script, cell: Cell) -> ScriptPace:
    """Return the pace of a script by the durations of a cell."""
    line = PacedLine(script, cell)
    return ScriptPace(script.name, line.pace(cell), quicker(line, cell), roomier(line, cell))


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
