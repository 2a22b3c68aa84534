"""The source of an overview: a running engine, or a past state."""

from __future__ import annotations

from typing import Protocol

from bt_orchestrator.engine.tree.compile import CellTree
from bt_orchestrator.model.state import CellState
from bt_orchestrator.ports import Goal, Servers


class Goals(Protocol):
    """The goals in flight."""

    def goal(self, goal_id: str) -> Goal | None:
        """Return a goal; None: it is not known."""


class Engine(Protocol):
    """One cell, its tree and its robots, as `Orchestrator` has them."""

    @property
    def state(self) -> CellState:
        """The state."""

    @property
    def tree(self) -> CellTree:
        """Its behaviours, ticked."""

    @property
    def gateway(self) -> Servers:
        """Its action servers as seen."""

    @property
    def flights(self) -> Goals:
        """Its goals in flight."""

    @property
    def broken(self) -> str | None:
        """Why the engine has stopped; None: it works."""

    @property
    def disk_wait(self) -> str:
        """The write that the disk has not finished; empty: none."""
