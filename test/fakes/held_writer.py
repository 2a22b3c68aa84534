"""A disk that takes what is written when it is told to, and not before."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from bt_orchestrator.engine.runtime.writers import Writing


class HeldWriter:
    """Implements `ports.Writer`; begins fast."""

    def __init__(self) -> None:
        self.is_slow = False
        self.held: list[Writing[Any]] = []

    def begin(self, write: Callable[[], Any]) -> Writing[Any]:
        """Keep it for `release`, or write."""
        writing = _Impatient(write, lambda: None)
        self.held.append(writing)
        if not self.is_slow:
            self.release()
        return writing

    def reaches_disk(self) -> None:
        """Do nothing: each write that is kept is at the disk."""

    def release(self) -> None:
        """Write what is kept."""
        held, self.held = self.held, []
        for writing in held:
            writing.run()


class _Impatient(Writing[Any]):
    """Waits for nothing: what has not ended is at the disk."""

    def is_at_disk(self, within_s: float) -> bool:
        return not self.has_ended(within_s)

    def has_ended(self, within_s: float = 0.0) -> bool:
        return super().has_ended(0.0)
