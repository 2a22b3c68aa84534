"""What behaviours that wait have in common: the wait as a fact, and as their feedback."""

from __future__ import annotations

from bt_orchestrator.model.wait import Wait
from bt_orchestrator.tree.subject import Subject


class Waiter:
    """A behaviour that may have to wait; mixed into those of py_trees."""

    wait: Wait | None = None
    """What it waited for in its last tick; None: nothing."""
    feedback_message: str

    @property
    def components(self) -> tuple[str, ...]:
        """Names of the components that it keeps from working while it waits."""
        return ()

    def note(self, wait: Wait | None) -> None:
        """Note what it waits for, and say so."""
        self.wait = wait
        self.feedback_message = '' if wait is None else wait.reason


class TaskWaiter(Waiter):
    """A behaviour about one task."""

    subject: Subject

    @property
    def components(self) -> tuple[str, ...]:
        """The task's own."""
        return (self.subject.task.component,)
