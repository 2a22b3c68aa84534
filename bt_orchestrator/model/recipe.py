"""The recipe: how one item is made, without equipment (ISA-88 master recipe, ISA-95 Work Master).

Operations name capabilities; which component does each, in which section and when, is decided when
a script (the control recipe) is generated for a cell.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from bt_orchestrator.model.cell import HoldAfter
from bt_orchestrator.model.reference import Template
from bt_orchestrator.model.script import Likely, Parameter


@dataclass(frozen=True)
class Operation:
    """One step of making an item; it becomes one task."""

    id: str
    do: tuple[str, ...]
    """Names of capabilities that can do it; the first is taken where nothing else decides."""
    after: tuple[str, ...] = ()
    """Ids of the operations directly before it, whether written or only the one above."""
    parameters: Mapping[str, Any] = field(default_factory=dict)
    """Values of the capability's parameters; strings with references are Templates."""
    needs: Mapping[str, str] = field(default_factory=dict)
    """Id of the operation that tells each thing that the capability needs."""
    options: Mapping[str, Any] = field(default_factory=dict)
    """Values of further fields of `model.script.Task`; only of those that were written."""


@dataclass(frozen=True)
class Rework:
    """Operations that are repeated together until their verdicts are met: `repeat`."""

    operations: tuple[str, ...]
    """Ids, in the order in which they are done."""
    times: int
    """Further rounds after the first one, at most."""


@dataclass(frozen=True)
class Recipe:
    """How one product is made, whatever cell makes it."""

    name: str
    version: int
    script: str
    """Name of the script that is generated from it."""
    operations: tuple[Operation, ...]
    """In the order written; `after` may name one that is written later, but makes no circle."""
    params: Mapping[str, Parameter] = field(default_factory=dict)
    """A parameter that an order may set."""
    reworks: tuple[Rework, ...] = ()
    lots: Mapping[str, Template] = field(default_factory=dict)
    """As those of a script."""
    likely: Mapping[str, Likely] = field(default_factory=dict)
    """By the id of the operation; changes nothing of the script but this, nor its digest."""
    hold_after: HoldAfter | None = None
    first_piece: bool = False
    """As those of a script."""

    @cached_property
    def by_id(self) -> Mapping[str, Operation]:
        """The operations by their ids."""
        return {operation.id: operation for operation in self.operations}


@dataclass(frozen=True)
class Overrides:
    """Decisions of an engineer about one generated script; they survive generating anew."""

    bind: Mapping[str, str] = field(default_factory=dict)
    """Component that does an operation, by the operation's id."""
    options: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    """Values of fields of `model.script.Task`, by the operation's id: the key `set`."""
    order: tuple[tuple[str, ...], ...] = ()
    """Lists of operations, each done in the order given."""
