"""Questions about what was, and about what would be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

from bt_orchestrator.model.requests import Asked
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.ports.door import Moment


class Past(Protocol):
    """Any past state of a cell, from its journal."""

    def status_at(self, seq: int, at: float | None = None) -> CellStatus:
        """Return the status of the cell after an event, with the reasons why it waited.

        :param at: a moment before the next event; None: the moment of the event
        :raises NotKept: that event, or what came before it, is not in the journal
        """


class ExpectedJob(NamedTuple):
    """When a job is expected to end."""

    job: str
    ends_s: float | None
    """Seconds from the given moment; None: it does not end in the present situation."""


class Consequence(NamedTuple):
    """The effects of some requests."""

    before: Sequence[ExpectedJob]
    after: Sequence[ExpectedJob]
    refusals: Sequence[str]
    """Messages of the requests that would be refused, in order; empty: none."""
    unknown: Mapping[str, str] = {}
    """Why a job has no end after them, by its id."""
    notes: Sequence[str] = ()
    """What the node will look at in earnest, and could not be looked at, in sentences."""


class WrongField(NamedTuple):
    """A mistake in one key of a work order."""

    field: str
    """For instance params.lot; empty: of the order as a whole."""
    what: str
    hint: str


class CheckedOrder(NamedTuple):
    """What would be said of a work order."""

    accepted: bool
    message: str
    """Why it would be refused, or not be checked; empty: it would be accepted."""
    wrong: Sequence[WrongField] = ()
    is_checked: bool = True
    """False: its script is not known here; the node may know it."""


class WhatIf(Protocol):
    """Predicts the effect of requests on jobs, with the engine that runs the cell."""

    def ask(self, requests: Sequence[Asked]) -> Consequence:
        """Predict when jobs end without and with these requests.

        :raises NotKept: the state to start from is not available
        """

    def check(self, order: Mapping[str, object]) -> CheckedOrder:
        """Tell whether an order, with the keys of an order file, would be queued.

        :raises NotKept: the state to start from is not available
        """


class Planning(Protocol):
    """Answers a planner's questions outside the asking process. One thread at a time."""

    def what_if(self, moment: Moment, requests: Sequence[Asked]) -> Consequence:
        """Predict when jobs end from a moment on, without and with these requests.

        :raises NotKept: nothing could be worked out
        """

    def check(self, moment: Moment, order: Mapping[str, object]) -> CheckedOrder:
        """Tell whether an order, with the keys of an order file, would be queued.

        :raises NotKept: nothing could be worked out
        """

    def close(self) -> None:
        """Stop working; may be called from any thread."""
