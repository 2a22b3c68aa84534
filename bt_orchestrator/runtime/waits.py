"""Who waits for what, in words (semantics 7.4)."""

from __future__ import annotations

from typing import NamedTuple

from bt_orchestrator.runtime.orchestrator import Orchestrator
from bt_orchestrator.tree.reasons import waiting


class Wait(NamedTuple):
    """One part of the cell and what it waits for."""

    part: str
    """initialization, section N or belt."""
    reason: str

    def __str__(self) -> str:
        return f'{self.part}: {self.reason}'


def waits(orchestrator: Orchestrator) -> list[Wait]:
    """Return every wait of the last tick, in the order of the belt."""
    tree = orchestrator.tree
    sections = [(f'section {n}', tree.sections[n]) for n in sorted(tree.sections)]
    parts = [('initialization', tree.initialization), *sections, ('belt', tree.belt)]
    return [Wait(name, reason) for name, part in parts for reason in waiting(part)]
