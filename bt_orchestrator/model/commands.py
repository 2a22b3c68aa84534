"""Commands to the cell, and their answers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from bt_orchestrator.model.by import By
from bt_orchestrator.model.jobs.job_commands import OfOrders
from bt_orchestrator.model.packml import Cause
from bt_orchestrator.model.requests import Asked


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
    names: tuple[str, ...] = ()
    """Ids of the orders, each with a record of its own; empty: without an id."""
    each: tuple[str, ...] = ()
    """The message for each of them, if they differ."""
    about: Mapping[str, str] = field(default_factory=dict)
    """The field of its record that names its subject."""


OnRecord = Asked | OfOrders | RefusedRequest
"""Commands that are recorded with their sender."""

Command = OnRecord | FoundTwin | Shutdown


def cancels_all(command: Command) -> bool:
    """Tell whether a command cancels every goal."""
    is_abort = isinstance(command, Asked) and command.request.cause is Cause.ABORT
    return is_abort or isinstance(command, Shutdown)


@dataclass(frozen=True)
class OrderAnswer:
    """The result for one of several work orders in one request."""

    job: str = ''
    """Id of the queued job; empty: not queued."""
    message: str = ''
    """The effect of a command, or the reason of its refusal."""
    findings: tuple[str, ...] = ()
    """Every mistake found, as file:line:column: what; hint."""


@dataclass(frozen=True)
class Answer:
    """The answer to a command."""

    accepted: bool
    message: str
    """The effect of a command, or the reason of its refusal and the remedy."""
    each: tuple[str, ...] = ()
    """The message for each part, if a request with several parts was refused."""
    orders: tuple[OrderAnswer, ...] = ()
    """The result for each work order, in order; empty: there were none, or none was read."""
