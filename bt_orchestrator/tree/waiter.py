"""Base of waiting behaviours: the wait as data, and as their feedback."""

from __future__ import annotations

from bt_orchestrator.model.contest import NO_CONTEST, Contest
from bt_orchestrator.model.wait import Wait, WaitKind
from bt_orchestrator.tree.subject import Recorder, Subject


def waits_for_one_server(recorder: Recorder, component: str) -> Wait | None:
    """Say who else has a part in a component now (semantics 2.5); None: nobody.

    It looks at the servers too: the event for what is seen now comes only later.
    """
    contest = recorder.state.contests.get(component)
    if not contest:
        rivals = recorder.rivals(component)
        contest = Contest(tuple(rivals)) if rivals else NO_CONTEST
    if not contest:
        return None
    action = recorder.state.cell.components[component].action
    return Wait(contest.wait(component, action), WaitKind.READINESS, component)


class Waiter:
    """A behaviour that may have to wait; a mixin for py_trees behaviours."""

    wait: Wait | None = None
    """What it waited for in its last tick; None: nothing."""
    feedback_message: str

    @property
    def components(self) -> tuple[str, ...]:
        """Names of the components that it blocks while it waits."""
        return ()

    def note(self, wait: Wait | None) -> None:
        """Store what it waits for, and set the feedback."""
        self.wait = wait
        self.feedback_message = '' if wait is None else wait.reason


class TaskWaiter(Waiter):
    """A behaviour about one task."""

    subject: Subject

    @property
    def components(self) -> tuple[str, ...]:
        """The task's component."""
        return (self.subject.task.component,)
