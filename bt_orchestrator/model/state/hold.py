"""A question that waits for an operator."""

from __future__ import annotations

from dataclasses import dataclass

from bt_orchestrator.model.events import TaskKey
from bt_orchestrator.model.pauses import NAMED
from bt_orchestrator.model.words import Words


@dataclass(frozen=True)
class Hold:
    """Something that waits for an operator (semantics 7.1)."""

    id: str
    job: str | None
    section: int | None
    item: str | None
    task: str | None
    reason: str
    message: str
    answers: tuple[str, ...]
    """The possible answers now; they change with the item and its job."""
    since: float
    owner: str = ''
    """The person who paused the cell; empty: not one person."""
    name: str = ''
    """Task constant; this and the following are empty, or 0, where no task is held."""
    component: str = ''
    action: str = ''
    attempt: int = 0
    """Number of the attempt that failed, from 1; 0: none was made."""
    attempts: int = 0
    """Attempts that the script allows."""
    round: int = 0
    """The number of the further round of its repeat, from 1; 0: the first pass, or no repeat."""
    message_words: tuple[Words, ...] = ()
    """Sentences of the node in the message, as facts; empty: they are known in words only."""
    controller_said: str = ''
    """Text of the controller's own result, cut."""
    last_feedback: str = ''
    """Last feedback of the failed attempt, as one JSON object."""
    topic_says: str = ''
    """In doubt after a restart: what the action's status topic says of the goal."""
    answers_together: tuple[str, ...] = ()
    """Those that one list may give to several holds (`model.alike`)."""
    answers_why: str = ''
    """Why other answers are not offered; empty: nothing is left out."""

    @property
    def is_pause(self) -> bool:
        """Tell whether it is about no task and no item, but about the whole cell."""
        return self.task is None and self.item is None

    @property
    def must_be_named(self) -> bool:
        """Tell whether only naming it releases it (semantics 7.3)."""
        return self.is_pause and self.reason in NAMED

    @property
    def key(self) -> TaskKey | None:
        """The task that is held, if it is a task."""
        if self.task is None:
            return None
        return TaskKey(self.job, self.section, self.item, self.task)
