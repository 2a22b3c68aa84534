"""The position of the belt and the state of the components."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from bt_orchestrator.model.frozen import made_at_once
from bt_orchestrator.model.state.tasks import PassedTask


@made_at_once
@dataclass(frozen=True)
class Cycle:
    """A section's pass through its list for one item."""

    job: str
    item: str
    beat: int
    """The beat its turn belongs to (semantics 3.7)."""
    rounds: Mapping[str, int] = field(default_factory=dict)
    """Further rounds begun, by the name of the repeat (semantics 3.9)."""
    round_causes: Mapping[str, str] = field(default_factory=dict)
    """Why the last of these rounds began, by the name of the repeat."""


@dataclass(frozen=True)
class Finished:
    """The outcome of a completed cycle."""

    job: str
    item: str
    beat: int
    """The beat of the cycle."""
    passed: tuple[PassedTask, ...] = ()
    failed: tuple[str, ...] = ()
    """Ids of tasks that failed and were passed all the same."""


@dataclass
class SectionState:
    """One section: its cycle in hand and its turn."""

    number: int
    cycle: Cycle | None = None
    turn_beat: int = 0
    """The last beat in which it completed a turn."""
    slot: str | None = None
    """Item, or empty position, that stands here."""
    finished: Finished | None = None
    """The last cycle that it completed, until the belt has moved after it."""


@dataclass
class FlagState:
    """The counter of a lateral dependency (semantics 4.1)."""

    count: int
    capacity: int


@dataclass(frozen=True)
class Reading:
    """Last value of a component's state topic; not ready before the first one."""

    ready: bool
    value: Any = None


@dataclass(frozen=True)
class KnownSetup:
    """The present value of a setup (semantics 5.3)."""

    value: str
    server: str | None = None
    """Instance of the server that made it; None: not known."""


@dataclass(frozen=True)
class OutOfService:
    """A component that an operator took out of service (semantics 7.5)."""

    reason: str
    """The person who did it, and the reason."""
    since: float
