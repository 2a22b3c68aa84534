"""Signs that stand beside words, in Unicode and in ASCII; colour is never the only sign."""

from __future__ import annotations

from typing import NamedTuple

from bt_orchestrator.model.branch import Outcome
from bt_orchestrator.view.screen.view import Weight


class Glyphs(NamedTuple):
    """The signs and their places."""

    working: str
    waiting: str
    held: str
    packed: str
    on_line: str
    to_come: str
    wall: str
    empty: str
    rest: str
    move: str
    success: str
    failure: str
    rejected: str
    nonconforming: str
    ellipsis: str
    rule: str

    def of_row(self, weight: Weight) -> str:
        """Return the sign of a section's row."""
        signs = {Weight.HELD: self.held, Weight.WORKING: self.working}
        return signs.get(weight, self.waiting)

    def of_status(self, status: Outcome) -> str:
        """Return the sign of a behaviour's status."""
        return {
            Outcome.RUNNING: self.working,
            Outcome.SUCCESS: self.success,
            Outcome.FAILURE: self.failure,
            Outcome.INVALID: self.waiting,
        }[status]


UNICODE = Glyphs('▶', '·', '■', '█', '▒', '░', '│', '·', '→', '»', '✓', '✗', '✗', '≈', '…', '─')
ASCII = Glyphs('>', '.', '!', '#', '=', '-', '|', '.', '->', '>>', '+', 'x', 'x', '~', '.', '-')
