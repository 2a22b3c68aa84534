"""The behaviours around a section's task list: its cycle, its turn, its next cycle."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_orchestrator.engine.tree.subject import Recorder, Subject, Waiter, is_done
from bt_orchestrator.engine.tree.ticking import FirstOf, InOrder, Ticked, invalidate
from bt_orchestrator.model import events as e
from bt_orchestrator.model.line import is_first_piece, next_cycle
from bt_orchestrator.model.script import Script, Task
from bt_orchestrator.model.state import Cycle, SectionState
from bt_orchestrator.model.wait import Wait


class Section(FirstOf):
    """One section: the branch of its current job, else the begin of its next cycle."""

    def __init__(self, recorder: Recorder, number: int) -> None:
        self._next_cycle = NextCycle(recorder, number)
        super().__init__(f'section {number}', [self._next_cycle])
        self._recorder = recorder
        self._number = number
        self._cycle: Cycle | None = None
        """The cycle in progress at the last tick."""

    def run(self) -> Status:
        """Tick the current branch; check all only with another cycle or a new branch."""
        cycle = self._recorder.state.sections[self._number].cycle
        if cycle is self._cycle and self.status is Status.RUNNING:
            return self.current_child.run()  # type: ignore[no-any-return,union-attr]
        self._cycle = cycle
        invalidate(self.children)
        return super().run()

    def tell(self, wait: Wait) -> None:
        """Note what it waits for, without a tick; only while it waits for its next cycle."""
        self._next_cycle.note(wait)


class _OfSection(Ticked):
    """Base of the behaviours of one section."""

    def __init__(self, name: str, recorder: Recorder, section: int) -> None:
        super().__init__(name)
        self.recorder = recorder
        self.number = section

    @property
    def section(self) -> SectionState:
        """The section's present state."""
        return self.recorder.state.sections[self.number]

    @property
    def cycle(self) -> Cycle:
        """The cycle in progress; called only during one."""
        assert self.section.cycle is not None
        return self.section.cycle


class CycleOf(_OfSection):
    """Condition: the cycle in progress is for this job; the section restarts with each cycle."""

    def __init__(self, recorder: Recorder, section: int, job: str) -> None:
        super().__init__(f'works on {job}', recorder, section)
        self.job = job

    def update(self) -> Status:
        """Return FAILURE for another job: the section then tries its other branches."""
        cycle = self.section.cycle
        if cycle is None or cycle.job != self.job:
            self.feedback_message = ''
            return Status.FAILURE
        is_aborting = self.recorder.state.jobs[self.job].aborting
        self.feedback_message = (
            f'{cycle.item}, the job is being aborted' if is_aborting else cycle.item
        )
        return Status.SUCCESS


class ReleaseConveyor(_OfSection):
    """Completes the section's turn: the belt may then move (semantics 3.5, 3.8)."""

    def __init__(self, recorder: Recorder, section: int) -> None:
        super().__init__('release conveyor', recorder, section)

    def update(self) -> Status:
        """Record the turn, once per cycle."""
        cycle = self.cycle
        if self.section.turn_beat < cycle.beat:
            done = e.TurnCompleted(job=cycle.job, section=self.number, item=cycle.item)
            self.recorder.record([done])
        return Status.SUCCESS


class CompleteCycle(_OfSection):
    """Ends the cycle."""

    def __init__(self, recorder: Recorder, section: int) -> None:
        super().__init__('complete cycle', recorder, section)

    def update(self) -> Status:
        """Record the end. RUNNING: the next cycle begins in the next tick."""
        cycle = self.cycle
        done = e.CycleCompleted(job=cycle.job, section=self.number, item=cycle.item)
        self.recorder.record([done])
        self.feedback_message = f'finished with {cycle.item}'
        return Status.RUNNING


class NextCycle(_OfSection, Waiter):
    """Begins the section's next cycle when it may (semantics 3.4, 3.7); never ends."""

    def __init__(self, recorder: Recorder, section: int) -> None:
        super().__init__('next cycle', recorder, section)

    def update(self) -> Status:
        """Begin a cycle, or say what the section waits for."""
        state = self.recorder.state
        begin = next_cycle(state, self.section)
        if isinstance(begin, Wait):
            self.note(begin)
            return Status.RUNNING
        self.note(None)
        if not state.jobs[begin.job].started:
            self.recorder.record([e.JobStarted(job=begin.job)])
        started = e.CycleStarted(
            job=begin.job, section=self.number, item=begin.item, beat=begin.beat
        )
        self.recorder.record([started])
        job = state.jobs[begin.job]
        if job.wants_piece and is_first_piece(state, job, self.number):
            self.recorder.record([e.JobPaused(job=begin.job, item=begin.item)])
        self.feedback_message = f'begins with {begin.item}'
        return Status.RUNNING


# Paging of long lists: the tree's size is independent of a script's length.
#
# Creating the behaviours of a task takes about 0.3 ms of the only thread, and each tick, viewer
# and readiness check goes through all of them.

MOST_WHOLE = 200
"""A script with no more tasks than this is in the tree completely, for viewers."""

PAGE = 40
"""Tasks of a page; a step is never split."""

_T = TypeVar('_T')


def is_long(script: Script) -> bool:
    """Tell whether the lists of a script are in pages."""
    return len(script.tasks) > MOST_WHOLE


def paged(parts: Sequence[_T], tasks_of: Callable[[_T], int]) -> Iterator[Sequence[_T]]:
    """Split a list of steps, or of the tasks of a track, into pages.

    :param tasks_of: returns the number of tasks of a part
    """
    page: list[_T] = []
    size = 0
    for part in parts:
        page.append(part)
        size += tasks_of(part)
        if size >= PAGE:
            yield page
            page, size = [], 0
    if page:
        yield page


class ListPage(InOrder):
    """A part of a long list, with behaviours only while the section works on it.

    When the last tasks have succeeded, all tasks before them have too, so they tell whether a page
    is passed: a tree compiled in the middle creates only what it needs.
    """

    def __init__(
        self,
        tasks: Sequence[Task],
        compiled: Callable[[], Sequence[Ticked]],
        last: Sequence[Subject],
    ) -> None:
        """Name a page after its tasks.

        :param compiled: creates its behaviours
        :param last: the tasks of its last step
        """
        super().__init__(f'{tasks[0].id} … {tasks[-1].id}', [])
        self._compiled = compiled
        self._last = last

    def run(self) -> Status:
        """Return SUCCESS if the page is passed, else create its behaviours and tick them."""
        if not self.children:
            if all(map(is_done, self._last)):
                self.status = Status.SUCCESS
                return self.status
            for child in self._compiled():
                self.add_child(child)
            self.setup_with_descendants()
        if super().run() is Status.SUCCESS:
            self._forget()
        return self.status

    def stop(self, new_status: Status = Status.INVALID) -> None:
        """Set the status; INVALID: the section works elsewhere."""
        super().stop(new_status)
        if new_status is Status.INVALID:
            self._forget()

    def _forget(self) -> None:
        for child in self.children:
            for behaviour in child.iterate():
                detach(behaviour)
        self.remove_all_children()
        self.current_child = None


def detach(behaviour: Behaviour) -> None:
    """Close a behaviour's blackboard clients; py_trees would never release them."""
    for client in behaviour.blackboards:
        client.unregister()
    behaviour.blackboards.clear()
