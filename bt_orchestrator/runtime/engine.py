"""What can be looked at: an engine at work, or one moment of the past."""

from __future__ import annotations

from typing import Protocol

from bt_orchestrator.model.state import CellState
from bt_orchestrator.ports import Goal, Servers
from bt_orchestrator.tree.compile import CellTree


class Goals(Protocol):
    """The goals in flight."""

    def goal(self, goal_id: str) -> Goal | None:
        """Return a goal; None: nothing is known of it."""


class Engine(Protocol):
    """One cell, its tree and its robots, as `Orchestrator` has them."""

    @property
    def state(self) -> CellState:
        """What is so."""

    @property
    def tree(self) -> CellTree:
        """Its behaviours, ticked."""

    @property
    def gateway(self) -> Servers:
        """What is seen of its robots."""

    @property
    def flights(self) -> Goals:
        """Its goals in flight."""

    @property
    def broken(self) -> str | None:
        """Why nothing is done any more."""

    @property
    def disk_wait(self) -> str:
        """What the disk has not taken yet."""
