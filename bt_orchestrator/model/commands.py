"""What people and other systems ask of the cell, and the answers they get."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from bt_orchestrator.model.by import By
from bt_orchestrator.model.cell_commands import CellCommand
from bt_orchestrator.model.jobs.job_commands import JobCommand


@dataclass(frozen=True)
class AnswerHold:
    """Decide about something that is held (semantics 7.1)."""

    hold: str
    answer: str
    """One of the answers that the hold offers."""
    by: By
    results: Mapping[str, Any] = field(default_factory=dict)
    """Of `mark_done`: result fields of the task, for references of later tasks (semantics 6.3)."""


@dataclass(frozen=True)
class RemoveItem:
    """Record that an item was taken off the belt by hand (semantics 7.1)."""

    item: str
    by: By


@dataclass(frozen=True)
class FoundTwin:
    """Start nothing more: another node answers under the name of this one (semantics 7.3)."""

    where: str
    """In words."""


@dataclass(frozen=True)
class Shutdown:
    """Cancel every goal and start nothing more (semantics 2.6)."""


@dataclass(frozen=True)
class RefusedRequest:
    """What came to nothing before it was a command: an order with mistakes, an unknown word.

    It changes nothing, and is put on record like any command that is refused.
    """

    verb: str
    by: By
    message: str
    """Why it is refused."""
    jobs: tuple[str, ...] = ()
    """Ids of the jobs it is about; empty for an order that has none."""
    each: tuple[str, ...] = ()
    """What is to be said of each job, if that is not the same of all."""


OnRecord = AnswerHold | RemoveItem | CellCommand | JobCommand | RefusedRequest
"""Commands that somebody is responsible for."""

Command = OnRecord | FoundTwin | Shutdown


@dataclass(frozen=True)
class OrderAnswer:
    """What became of one work order of several that were given together."""

    job: str = ''
    """Id of the queued job; empty: not queued."""
    message: str = ''
    """What was done, or why it was refused."""
    findings: tuple[str, ...] = ()
    """Every mistake found, as file:line:column: what; hint."""


@dataclass(frozen=True)
class Answer:
    """The answer to a command."""

    accepted: bool
    message: str
    """What was done, or why it was refused and what to do."""
    each: tuple[str, ...] = ()
    """Where several things were asked for and refused together: what is to be said of each."""
    orders: tuple[OrderAnswer, ...] = ()
    """What became of each work order, in their order; empty: it was not about any, or none of
    them was read."""
