"""Commands to the cell, and their answers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from bt_orchestrator.model.by import By
from bt_orchestrator.model.cell_commands import CellCommand
from bt_orchestrator.model.jobs.job_commands import JobCommand


@dataclass(frozen=True)
class AnswerHold:
    """Answer a hold (semantics 7.1)."""

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
class SetService:
    """Take a component out of service, or bring it back (semantics 7.5)."""

    component: str
    in_service: bool
    by: By


@dataclass(frozen=True)
class ReleaseScript:
    """Let jobs of a generated script start (semantics 6.10)."""

    digest: str
    by: By | None = None
    """None: the plan of a virtual run, in which nobody is there to release it."""
    cell_digest: str = ''
    """Of the cell that it was generated for, if that is to be compared."""


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
    """A request refused before it became a command: an order with mistakes, an unknown word.

    It changes nothing, and is recorded like any refused command.
    """

    verb: str
    by: By
    message: str
    """Why it is refused."""
    jobs: tuple[str, ...] = ()
    """Ids of the jobs concerned; empty for an order without an id."""
    each: tuple[str, ...] = ()
    """The message for each job, if they differ."""


OnRecord = (
    AnswerHold
    | RemoveItem
    | SetService
    | ReleaseScript
    | CellCommand
    | JobCommand
    | RefusedRequest
)
"""Commands that are recorded with their sender."""

Command = OnRecord | FoundTwin | Shutdown


@dataclass(frozen=True)
class OrderAnswer:
    """The result for one of several work orders in one request."""

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
    """The message for each part, if a request with several parts was refused."""
    orders: tuple[OrderAnswer, ...] = ()
    """The result for each work order, in order; empty: there were none, or none was read."""
