"""A view of the news of a node: on a terminal, as plain lines, or as JSON."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from bt_orchestrator.model.branch import Branch
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.status import CellStatus

SILENT_S = 3.0
"""Seconds without a status after which a node counts as away; it sends one a second."""


class Viewer(Protocol):
    """Gets the news as they come; everything in one thread."""

    def on_status(self, status: CellStatus) -> None:
        """Show how the cell stands."""

    def on_event(self, event: Event) -> None:
        """Show what happened."""

    def on_tree(self, tree: Branch) -> None:
        """Show the behaviour tree."""

    def on_blackboard(self, values: Mapping[str, str]) -> None:
        """Show the variables of the blackboard."""

    def refresh(self) -> None:
        """Show how time passes; called a few times a second."""


class Hearing:
    """Since when nothing is heard of a node."""

    def __init__(self, now: float) -> None:
        self._heard_at = now

    def heard(self, now: float) -> None:
        """Take note of a status."""
        self._heard_at = now

    def age_s(self, now: float) -> float:
        """Return how old the last status is."""
        return now - self._heard_at

    def silent_s(self, now: float) -> float | None:
        """Return for how long the node has been away; None: it is there."""
        age_s = self.age_s(now)
        return age_s if age_s > SILENT_S else None
