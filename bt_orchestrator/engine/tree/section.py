"""The behaviours around a section's task list: its cycle, its turn, its next cycle."""

from __future__ import annotations

from py_trees.common import Status

from bt_orchestrator.engine.tree.subject import Recorder
from bt_orchestrator.engine.tree.ticking import FirstOf, Ticked, invalidate
from bt_orchestrator.engine.tree.waiter import Waiter
from bt_orchestrator.model import events as e
from bt_orchestrator.model.line import next_cycle
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
        self.feedback_message = f'begins with {begin.item}'
        return Status.RUNNING
