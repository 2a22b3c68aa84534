"""Base of waiting behaviours: the wait as data, and as their feedback."""

from __future__ import annotations

from bt_orchestrator.model.wait import Wait


class Waiter:
    """A behaviour that may have to wait; a mixin for py_trees behaviours."""

    wait: Wait | None = None
    """The cause of its wait in its last tick; None: no wait."""
    feedback_message: str

    def note(self, wait: Wait | None) -> None:
        """Store what it waits for, and set the feedback."""
        self.wait = wait
        self.feedback_message = '' if wait is None else wait.reason
