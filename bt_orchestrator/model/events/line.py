"""Events of the line: cycles, flags, the belt, items."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar

from bt_orchestrator.model.events.base import Event
from bt_orchestrator.model.events.tasks import TaskEvent
from bt_orchestrator.model.frozen import made_at_once


@dataclass(frozen=True, kw_only=True)
class CycleEvent(Event):
    """Base: one pass of a section through its list."""

    job: str
    section: int
    item: str


@made_at_once
@dataclass(frozen=True, kw_only=True)
class CycleStarted(CycleEvent):
    """A section begins its list for an item; at the source the item exists from here on."""

    event: ClassVar[str] = 'cycle.started'
    beat: int
    """The beat this cycle's turn belongs to; the one to come for a cycle begun ahead."""


@made_at_once
@dataclass(frozen=True, kw_only=True)
class TurnCompleted(CycleEvent):
    """The section releases the conveyor (semantics 3.4, 3.8)."""

    event: ClassVar[str] = 'turn.completed'


@made_at_once
@dataclass(frozen=True, kw_only=True)
class CycleCompleted(CycleEvent):
    """All steps of the list have ended."""

    event: ClassVar[str] = 'cycle.completed'


@dataclass(frozen=True, kw_only=True)
class RoundBegun(CycleEvent):
    """The tasks of a repeat are done once more for the item (semantics 3.9)."""

    event: ClassVar[str] = 'round.begun'
    repeat: str
    """Its first task."""
    n: int
    """The number of the further round of this cycle, from 1."""
    tasks: tuple[str, ...]
    """All of its tasks: they are new again, and have no results."""


@dataclass(frozen=True, kw_only=True)
class FlagEvent(TaskEvent):
    """A lateral dependency's counter changed, by the task named."""

    flag: str
    count: int
    """After the change."""


@dataclass(frozen=True, kw_only=True)
class FlagRaised(FlagEvent):
    """The upstream task executed: one more."""

    event: ClassVar[str] = 'flag.raised'


@dataclass(frozen=True, kw_only=True)
class FlagLowered(FlagEvent):
    """The downstream task executed: one less."""

    event: ClassVar[str] = 'flag.lowered'


@dataclass(frozen=True, kw_only=True)
class BeatStarted(Event):
    """A beat begins without a move, the belt being empty (semantics 3.5)."""

    event: ClassVar[str] = 'beat.started'
    beat: int


@dataclass(frozen=True, kw_only=True)
class BeltIndexStarted(Event):
    """The belt begins to move; this lasts until `belt.indexed`, retries and holds included."""

    event: ClassVar[str] = 'belt.index_started'
    beat: int
    """The beat that ends."""


@dataclass(frozen=True, kw_only=True)
class BeltIndexed(Event):
    """The belt is at rest one position further; every item has moved."""

    event: ClassVar[str] = 'belt.indexed'
    beat: int
    """The beat that begins."""


@dataclass(frozen=True, kw_only=True)
class ItemEvent(Event):
    """Something about one item."""

    job: str
    item: str


@dataclass(frozen=True, kw_only=True)
class ItemPlaced(ItemEvent):
    """The item stands in the slot of the source section."""

    event: ClassVar[str] = 'item.placed'
    section: int
    lots: Mapping[str, str] = field(default_factory=dict)
    """The lots that go into it, by the names in its script (semantics 6.9)."""


@dataclass(frozen=True, kw_only=True)
class ItemMissing(ItemEvent):
    """The item was never placed: an empty position stands in its slot (semantics 3.2)."""

    event: ClassVar[str] = 'item.missing'
    section: int


@dataclass(frozen=True, kw_only=True)
class ItemIdentified(ItemEvent):
    """A task, or an operator who marked it done, gave the serial of the item (semantics 6.8)."""

    event: ClassVar[str] = 'item.identified'
    task: str
    serial: str
    """The serial that was read, without white space around it."""


@made_at_once
@dataclass(frozen=True, kw_only=True)
class ItemMoved(ItemEvent):
    """The item, or empty position, moved into the slot of a section."""

    event: ClassVar[str] = 'item.moved'
    section: int
    """The section it moved into."""


@dataclass(frozen=True, kw_only=True)
class ItemRejected(ItemEvent):
    """The item is bad; remaining tasks skip it, except those for rejected items."""

    event: ClassVar[str] = 'item.rejected'
    reason: str


@dataclass(frozen=True, kw_only=True)
class ItemNonconforming(ItemEvent):
    """An operator let the item pass a task whose verdict it does not have (semantics 2.8)."""

    event: ClassVar[str] = 'item.nonconforming'
    task: str
    reason: str


@dataclass(frozen=True, kw_only=True)
class ItemRemoved(ItemEvent):
    """The item left the belt; by hand or before the sink, it leaves an empty position."""

    event: ClassVar[str] = 'item.removed'
    section: int | None = None
    how: str
    """packed, rejected or by_hand."""


@dataclass(frozen=True, kw_only=True)
class PositionEnded(ItemEvent):
    """An empty position ended at the sink (semantics 3.2)."""

    event: ClassVar[str] = 'position.ended'
    section: int
