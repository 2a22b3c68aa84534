"""The simulated components of a cell, and their faults."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.model.cell import Cell, Component
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.sim.fault_options import add_faults, unknown_component


class WrongSelection(OrchestratorError):
    """The choice on the command line does not fit the cell."""


def select(
    cell: Cell, only: Sequence[str], faults: Sequence[str], types: ActionTypes
) -> list[Component]:
    """Return the components to simulate, in the order of the cell file.

    :param only: names of components; none of them means all
    :param faults: as users write them, `COMPONENT.[TASK][#NTH]=KIND[:SECONDS]`; they add to those
        of the cell file
    :raises WrongSelection: with everything that is wrong, one mistake a line
    """
    mistakes = [
        f'--only {name}: {unknown_component(name, cell)}'
        for name in only
        if name not in cell.components
    ]
    chosen = {name: c for name, c in cell.components.items() if not only or name in only}
    mistakes += add_faults(chosen, cell, faults, types)
    if mistakes:
        raise WrongSelection('\n'.join(mistakes))
    return list(chosen.values())


def names(texts: Sequence[str]) -> Iterator[str]:
    """Yield the names in comma-separated lists."""
    return (name.strip() for text in texts for name in text.split(',') if name.strip())
