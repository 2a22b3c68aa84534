"""What the blackboard of a cell says, against the state."""

from __future__ import annotations

import weakref
from typing import Any

from py_trees.blackboard import Blackboard

from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.model.state import CellState

_left: list[str] = []
"""The places of cells that nobody knows any more."""


def tidy_after(orchestrator: Orchestrator) -> None:
    """Let what is said of a cell go with it: the blackboard is global, and each check reads it.

    Not at once, because somebody may be reading; when the next one is told of.
    """
    while _left:
        for key in shown(f'{_left.pop()}/'):
            Blackboard.unset(key)
    weakref.finalize(orchestrator, _left.append, orchestrator._projection.space).atexit = False


def check_board(space: str, state: CellState) -> None:
    """Fail unless the blackboard shows the state of this moment, and nothing else."""
    below = f'{space}/'
    board = {key[len(below) :]: value for key, value in shown(below).items()}
    # As flags do, zones stay when the last script that names them has gone; nobody is there then.
    left = {key for key in board if key.startswith('zones/')}
    assert board == dict.fromkeys(left, '') | expected(state)


def shown(below: str) -> dict[str, Any]:
    """Return the variables below a place."""
    return {key: value for key, value in Blackboard.storage.items() if key.startswith(below)}


def expected(state: CellState) -> dict[str, Any]:
    """Return what there is to see, by name."""
    zones = {zone.name for script in state.scripts.values() for zone in script.zones}
    return {
        'belt': 'moving' if state.indexing else 'at rest',
        'beat': state.beat,
        'cell': state.packml.value,
        **{f'flags/{name}': flag.count for name, flag in state.flags.items()},
        **{f'zones/{name}': str(state.zones.get(name, '')) for name in zones},
        **{f'components/{c}': str(state.reserved.get(c, '')) for c in state.cell.components},
        **{f'ready/{name}': reading.ready for name, reading in state.readings.items()},
        **{f'slots/{n}': section.slot or '' for n, section in state.sections.items()},
    }
