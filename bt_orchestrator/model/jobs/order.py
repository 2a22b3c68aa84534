"""Work orders, and the jobs they become."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from bt_orchestrator.model.script import Script


@dataclass(frozen=True)
class WorkOrder:
    """What a customer of the line asks for, as written."""

    script: str
    """Name of a script, or a path to one."""
    order: str | None = None
    quantity: int | None = None
    """None: the script's default."""
    params: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Job:
    """A work order accepted into the queue: a bound script, a quantity and all parameters."""

    id: str
    script: Script
    quantity: int
    """Number of source cycles, at least 1 (semantics 6.2)."""
    params: Mapping[str, Any] = field(default_factory=dict)
    """Every parameter of the script, defaults filled in."""

    def item(self, number: int) -> str:
        """Return the id of an item; numbers count from 1."""
        return f'{self.id}/{number}'
