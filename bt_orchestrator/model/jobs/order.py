"""Work orders, the jobs made from them, and why a job was made anew."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime, timezone
from typing import Any

from bt_orchestrator.model.script import Script
from bt_orchestrator.model.words import sentence


@dataclass(frozen=True)
class Terms:
    """Scheduling data of an order. Priority and start decide its place (semantics 6.7).

    Priority, start and due are Priority, StartTime and EndTime of ISA-95 Job Control (OPC 10031-4
    v2.00, table 64).
    """

    priority: int = 0
    """An Int16, the higher the more urgent, as the standard has it; customers choose the range."""
    start: float | None = None
    """When it should begin, seconds since the epoch; None: not said."""
    due: float | None = None
    """When it should have ended, seconds since the epoch; None: not said."""
    details: Mapping[str, object] = field(default_factory=dict)
    """JSON of the customer's own, never interpreted."""
    first_piece: bool = False
    """Its first item has to be approved, also where the script does not say so (6.12)."""

    @property
    def urgency(self) -> tuple[int, float]:
        """The value by which orders are compared: the smaller comes first."""
        return -self.priority, math.inf if self.start is None else self.start

    @property
    def start_words(self) -> str:
        """The start, in UTC; empty: not said."""
        if self.start is None:
            return ''
        moment = datetime.fromtimestamp(self.start, timezone.utc)
        return f'{moment:%Y-%m-%d %H:%M:%S} UTC'


NO_TERMS = Terms()


@dataclass(frozen=True)
class RecipeChoice:
    """The choice of an order in place of a script: recipes; the cell makes one of them."""

    recipes: tuple[str, ...]
    """Names; the first one that can be made is made."""
    version: int | None = None
    """None: the newest."""
    bind: Mapping[str, str] = field(default_factory=dict)
    """Component that does an operation, by its id; EquipmentRequirements in ISA-95."""

    def over(self, before: RecipeChoice | None) -> RecipeChoice:
        """Return what a job is made from when its order is changed; what is not named stays.

        Whoever names recipes says all of it: without a version the newest one counts again.
        """
        if self.recipes or before is None:
            return self
        version = before.version if self.version is None else self.version
        return RecipeChoice(before.recipes, version, {**before.bind, **self.bind})

    @property
    def words(self) -> str:
        """The recipes and the version, as messages name them."""
        version = '' if self.version is None else f' version {self.version}'
        return f'{" or ".join(self.recipes)}{version}'


@dataclass(frozen=True)
class WorkOrder:
    """A work order, as written by a customer: of a script, or of a recipe."""

    script: str = ''
    """Name of a script, or a path to one; empty: it names a recipe."""
    order: str | None = None
    quantity: int | None = None
    """None: the script's default."""
    params: Mapping[str, Any] = field(default_factory=dict)
    terms: Terms = NO_TERMS
    recipe: RecipeChoice | None = None
    """None: it names a script."""


@dataclass(frozen=True)
class Job:
    """A work order accepted into the queue: a bound script, a quantity and all parameters."""

    id: str
    script: Script
    quantity: int
    """Number of source cycles, at least 1 (semantics 6.2)."""
    params: Mapping[str, Any] = field(default_factory=dict)
    """Every parameter of the script, defaults filled in."""
    terms: Terms = NO_TERMS
    recipe: RecipeChoice | None = None
    """The recipe that the order named in place of a script: the job is made anew from it; None: a
    script."""

    def item(self, number: int) -> str:
        """Return the id of an item; numbers count from 1."""
        return f'{self.id}/{number}'


LONGEST_ORDER_ID = 64


def order_id_fault(text: str) -> str | None:
    """Say why a text cannot be a new order id, which begins the ids of its items; None: it can.

    Journals may have ids that were taken when less was asked of them.
    """
    if not text:
        return sentence('id_empty')
    if '/' in text:
        return sentence('id_slash')
    if text != text.strip():
        return sentence('id_space')
    if not text.isprintable():
        return sentence('id_unprintable')
    if '<' in text or '>' in text:
        return sentence('id_sign')
    if len(text) > LONGEST_ORDER_ID:
        return sentence('id_long', count=len(text), most=LONGEST_ORDER_ID)
    return None


# Why a job by recipe was made anew, and at what pace it is made since, for all surfaces.


@dataclass(frozen=True)
class MadeAnew:
    """A script was generated again, because other components are in service (semantics 7.5)."""

    without: tuple[str, ...] = ()
    """Components out of service that the script before needed, or did before it was made anew."""
    back: tuple[str, ...] = ()
    """Where none is: components that the script before did not need."""
    per_item_s: float = 0.0
    """Seconds from one item to the next; 0: not known."""
    before_s: float = 0.0
    """The same of the script before; where that was made without components, of the one before
    them. 0: not known."""

    @property
    def slower(self) -> float:
        """How much longer an item takes, as a part of the time before; 0: not known."""
        return self.per_item_s / self.before_s - 1 if self.before_s and self.per_item_s else 0.0

    @property
    def pace_words(self) -> str:
        """How long an item takes; empty: not known."""
        return compared_words(self.per_item_s, self.slower) if self.per_item_s else ''

    @property
    def words(self) -> str:
        """All in one sentence, as in `made anew without component_4b: 4.0 s per item (+33 %)`."""
        why = '_without' if self.without else '_with' if self.back else ''
        kind = f'made_anew{why}{"_at" if self.pace_words else ""}'
        components = ' and '.join(self.without or self.back)
        return sentence(kind, components=components, pace=self.pace_words)


def compared_words(per_item_s: float, slower: float) -> str:
    """Say how long one item takes, as in `18.1 s per item (+44 %)`.

    :param slower: than before, as a part of the time before
    """
    kind = 'per_item_changed' if round(slower, 2) else 'per_item'
    share = f'{slower:+.0%}'.replace('%', ' %')
    return sentence(kind, seconds=f'{per_item_s:.1f}', share=share)
