"""The live view: the whole terminal, drawn again whenever there is something new."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence

from rich.console import Group
from rich.text import Text

from bt_orchestrator.model.branch import Branch
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.view.screen import words
from bt_orchestrator.view.screen.advice import Shell
from bt_orchestrator.view.screen.picture import Picture
from bt_orchestrator.view.screen.terminal.second_screen import SecondScreen
from bt_orchestrator.view.screen.view import CellView, cell_view
from bt_orchestrator.view.screen.viewer import Hearing

PACE_S = 0.5
"""Longest time between two drawings: times of running tasks go on without news."""


class LiveView:
    """Draws its content on the terminal's second screen."""

    def __init__(self, screen: SecondScreen, shell: Shell) -> None:
        self._screen = screen
        self._shell = shell
        self._notes: tuple[str, ...] = ()
        self._view: CellView | None = None
        self._tree: Branch | None = None
        self._blackboard: Mapping[str, str] | None = None
        self._hearing = Hearing(time.monotonic())
        self._is_new = False
        self._drawn_at = 0.0
        self._drawn_size = screen.size

    def on_status(self, status: CellStatus) -> None:
        """Show how the cell stands."""
        self._view = cell_view(status, self._shell)
        self._hearing.heard(time.monotonic())
        self._is_new = True

    def on_event(self, event: Event) -> None:
        """Show nothing: the status shows what an event changes."""

    def on_notes(self, notes: Sequence[str]) -> None:
        """Show lines below all else."""
        self._is_new |= self._notes != tuple(notes)
        self._notes = tuple(notes)

    def on_tree(self, tree: Branch) -> None:
        """Show the behaviour tree in place of the sections."""
        self._tree = tree
        self._is_new = True

    def on_blackboard(self, values: Mapping[str, str]) -> None:
        """Show the variables of the blackboard below all else."""
        self._blackboard = values
        self._is_new = True

    def refresh(self) -> None:
        """Draw, if there is something new, the terminal has another size, or time has passed."""
        now, size = time.monotonic(), self._screen.size
        is_due = now - self._drawn_at >= PACE_S or size != self._drawn_size
        if not (self._is_new or is_due):
            return
        self._is_new, self._drawn_at, self._drawn_size = False, now, size
        self._screen.show(self._picture(now))

    def _picture(self, now: float) -> Picture | Group:
        if self._view is None:
            age = words.duration(self._hearing.age_s(now))
            return Group(*map(Text, (f'waiting for {self._shell.node}, {age}', *self._notes)))
        silent_s = self._hearing.silent_s(now)
        age_s = 0.0 if silent_s is not None else self._hearing.age_s(now)
        return Picture(
            self._view,
            self._shell.node,
            age_s,
            silent_s,
            self._tree,
            self._blackboard,
            self._notes,
        )
