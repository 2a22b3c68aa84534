"""Who waits for what (semantics 7.4)."""

from __future__ import annotations

from dataclasses import dataclass

from bt_orchestrator.model.wait import Wait
from bt_orchestrator.runtime.orchestrator import Orchestrator
from bt_orchestrator.tree.reasons import waits_of

INITIALIZATION = 'initialization'
BELT = 'belt'


@dataclass(frozen=True)
class PartWait:
    """One part of the cell and what it waits for."""

    part: str
    """initialization, section N, belt, or a component."""
    wait: Wait
    section: int | None = None
    """The section, if it is one."""
    components: tuple[str, ...] = ()
    """Those that would work otherwise."""

    @property
    def reason(self) -> str:
        """What it waits for, in words."""
        return self.wait.reason

    def __str__(self) -> str:
        return f'{self.part}: {self.wait}'


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
