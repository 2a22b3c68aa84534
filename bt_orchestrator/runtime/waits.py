"""Who waits for what (semantics 7.4)."""

from __future__ import annotations

from bt_orchestrator.model.wait import BELT, INITIALIZATION, PartWait
from bt_orchestrator.runtime.orchestrator import Orchestrator
from bt_orchestrator.tree.reasons import waits_of


def waits(orchestrator: Orchestrator) -> list[PartWait]:
    """Return every wait of the last tick, in the order of the belt."""
    tree = orchestrator.tree
    sections = [(f'section {n}', n, tree.sections[n]) for n in sorted(tree.sections)]
    parts = [(INITIALIZATION, None, tree.initialization), *sections, (BELT, None, tree.belt)]
    return [
        PartWait(name, wait, number, components)
        for name, number, part in parts
        for wait, components in waits_of(part).items()
    ]
