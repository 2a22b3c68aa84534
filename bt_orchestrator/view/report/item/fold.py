"""The fold from events to the record of one item."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from bt_orchestrator.model import events as e
from bt_orchestrator.model.hold_words import held_words
from bt_orchestrator.model.jobs.counting import APPROVED, PIECE_REFUSED, PIECE_WAITS
from bt_orchestrator.model.packml import VERBS, Cause
from bt_orchestrator.model.script import index_task
from bt_orchestrator.model.state import CellState
from bt_orchestrator.model.task_spans import TaskSpans
from bt_orchestrator.view.report.intervals import Span, gaps
from bt_orchestrator.view.report.item.history import (
    CONTINUED,
    FAILED,
    MARKED_DONE,
    RUNNING,
    SKIPPED,
    SUCCEEDED,
    Attempt,
    AtWork,
    Decision,
    Held,
    ItemHistory,
    Neighbour,
    Restart,
    Stay,
    Waited,
)
from bt_orchestrator.view.report.item.waits import ItemWaits


class ItemFold:
    """Takes in all events from the first of an item on, in order.

    Those of its job alone are enough for what happened to it, without what it waited for.
    """

    def __init__(self, item: str, job: str, state: CellState | None = None) -> None:
        """Begin.

        :param state: of the cell before, changed with the events; None: it is not known
        """
        self.history = ItemHistory(item, job)
        self._waits = ItemWaits(item, state)
        self._spans = TaskSpans()
        self._open: dict[e.TaskKey, Attempt] = {}
        self._running: dict[e.TaskKey, AtWork] = {}
        self._slots: dict[str, int] = {}
        """Sections of what stands on the belt."""
        self._time = 0.0
        self._decided_last: e.OperatorDecided | None = None
        if state is not None:
            tasks = ((key, state.task(key) or index_task(state.cell)) for key in state.running)
            self._running = {
                key: AtWork(task.component, task.name, key.item or '', key.section)
                for key, task in tasks
            }
            standing = state.sections.values()
            self._slots = {section.slot: section.number for section in standing if section.slot}

    @property
    def is_known(self) -> bool:
        """Tell whether any event was about the item."""
        history = self.history
        return bool(history.tasks or history.holds or history.decisions) or (
            history.started is not None or history.ended is not None
        )

    def follow(self, event: e.Event) -> None:
        """Take in the next event."""
        history = self.history
        self._waits.follow(event)
        if isinstance(event, e.OrderEvent):
            self.note_order(event)
        elif isinstance(event, e.TaskEvent):
            self._others(event)
            if event.item == history.item:
                self._task(event)
        else:
            fold = _FOLDS.get(type(event))
            if fold is not None:
                fold(self, event)
        self._time = event.time

    def note_order(self, event: e.Event) -> None:
        """Take in what an order says, if it is that of the item."""
        if isinstance(event, e.OrderEvent) and event.job == self.history.job:
            _order(self.history, event)

    @property
    def _is_there(self) -> bool:
        return self.history.started is not None and self.history.ended is None

    def _is_mine(self, event: e.HoldRaised | e.ItemEvent | e.CycleEvent) -> bool:
        return event.item == self.history.item

    # --- the item ---------------------------------------------------------------------------

    def _cycle_started(self, event: e.CycleStarted) -> None:
        history = self.history
        is_first = not history.stays and not history.tasks  # else its beginning is not kept
        if self._is_mine(event) and is_first and history.started is None:
            history.started = event.time

    def _stands(self, event: e.ItemPlaced | e.ItemMoved) -> None:
        self._slots[event.item] = event.section
        if self._is_mine(event):
            self._end_stay(event.time)
            self.history.stays.append(Stay(event.section, event.time))
            if isinstance(event, e.ItemPlaced):
                self.history.lots = event.lots

    def _belt_starts(self, event: e.BeltIndexStarted) -> None:
        self._end_stay(event.time)

    def _ended(self, event: e.ItemMissing | e.ItemRemoved) -> None:
        if isinstance(event, e.ItemMissing):
            self._slots[event.item] = event.section
        if self._is_mine(event):
            self._end_stay(event.time)
            self.history.ended = event.time
            self.history.idle = [*self._waits.rest(), *self._not_told(event.time)]
            self.history.how = event.how if isinstance(event, e.ItemRemoved) else 'missing'

        if isinstance(event, e.ItemRemoved):
            self._left(event)

    def _left(self, event: e.ItemRemoved | e.PositionEnded) -> None:
        self._slots.pop(event.item, None)

    def _not_told(self, ended: float) -> list[Waited]:
        """Return when it was not worked on, and the state of the cell is not known."""
        begun = self.history.started
        since = max(ended if begun is None else begun, self._waits.unknown_since)
        return [Waited(*gap, '', '') for gap in gaps(Span(since, ended), self.history.work)]

    def _identified(self, event: e.ItemIdentified) -> None:
        if self._is_mine(event):
            self.history.serial = event.serial

    def _rejected(self, event: e.ItemRejected) -> None:
        if self._is_mine(event):
            self.history.rejected = event.reason

    def _piece_waits(self, event: e.JobPaused) -> None:
        if event.item == self.history.item:
            self.history.first_piece = PIECE_WAITS

    def _piece_decided(self, event: e.JobResumed | e.JobStopping) -> None:
        if event.item != self.history.item:
            return
        is_refused = isinstance(event, e.JobStopping) or event.another
        self.history.first_piece = PIECE_REFUSED if is_refused else APPROVED
        if self._decided_last is not None:  # the record of the decision precedes it
            self.history.decisions.append(_decision(self._decided_last, of_cell=False))

    def _nonconforming(self, event: e.ItemNonconforming) -> None:
        if self._is_mine(event):
            self.history.nonconforming.append(event.task)

    def _end_stay(self, time: float) -> None:
        stay = self.history.stays[-1] if self.history.stays else None
        if stay is None or stay.until is not None:
            return
        stay.until = time
        others = sorted((section, item) for item, section in self._slots.items())
        stay.beside = tuple(Neighbour(*pair) for pair in others if pair[1] != self.history.item)

    # --- people, and the node ---------------------------------------------------------------

    def _hold(self, event: e.HoldRaised) -> None:
        of_cell = event.task is None and event.item is None
        if self._is_mine(event) or (of_cell and self._is_there):
            words = held_words(event)
            held = Held(event.hold, event.seq, event.time, event.task or '', words, of_cell)
            self.history.holds.append(held)

    def _released(self, event: e.HoldReleased) -> None:
        for held in self.history.holds:
            if held.id == event.hold:
                held.ended = event.time

    def _decided(self, event: e.OperatorDecided) -> None:
        self._decided_last = event
        is_mine = event.item == self.history.item
        of_hold = event.hold is not None and any(h.id == event.hold for h in self.history.holds)
        # `resume` is to the cell, also where it names a hold.
        hold = None if event.answer == VERBS[Cause.UNHOLD] else event.hold
        about = (event.job, event.item, event.component, event.stop, hold)
        of_cell = not is_mine and not any(about)
        if is_mine or of_hold or (of_cell and self._is_there):
            self.history.decisions.append(_decision(event, of_cell=of_cell))

    def _restarted(self, event: e.OrchestratorStarted) -> None:
        if self._is_there:
            words = 'the journal was brought back from a copy' if event.restored else event.missing
            self.history.restarts.append(Restart(event.time, self._time, words))

    # --- attempts ---------------------------------------------------------------------------

    def _others(self, event: e.TaskEvent) -> None:
        """Note at each attempt that runs what else runs."""
        if isinstance(event, (e.TaskSucceeded, e.TaskFailed)):
            self._running.pop(event.key, None)
        if not isinstance(event, e.TaskStarted):
            return
        at_work = AtWork(event.component, event.name, event.item or '', event.section)
        for key, attempt in self._open.items():
            if key != event.key:
                attempt.beside.append(at_work)
        self._running.pop(event.key, None)
        if event.item == self.history.item:
            self._open[event.key] = _begun(event, list(self._running.values()))
        self._running[event.key] = at_work

    def _task(self, event: e.TaskEvent) -> None:
        span = self._spans.follow(event)
        attempt = self._open.get(event.key)
        if isinstance(event, e.TaskStarted):
            assert attempt is not None
            attempt.waited = self._waits.before(event.key)
            self.history.tasks.append(attempt)
        elif isinstance(event, (e.TaskSucceeded, e.TaskFailed)):
            self._open.pop(event.key, None)
            if attempt is None:
                attempt = Attempt(event.section, event.task, RUNNING)
                self.history.tasks.append(attempt)
            attempt.attempt, attempt.ended = event.attempt, event.time
            attempt.seconds = span.seconds if span else None
            _end(attempt, event)
        elif isinstance(event, (e.TaskSkipped, e.TaskMarkedDone, e.TaskContinued)):
            passed = _passed(event)
            passed.waited = self._waits.before(event.key)
            self.history.tasks.append(passed)
            if isinstance(event, e.TaskContinued) and event.nonconforming:
                self.history.nonconforming.append(event.task)
        elif attempt is not None:
            _note(attempt, event)


def _order(history: ItemHistory, event: e.OrderEvent) -> None:
    history.script, history.digest = event.script, event.digest
    history.recipe, history.recipe_version = event.recipe, event.recipe_version
    history.quantity, history.params = event.quantity, event.params


def _decision(event: e.OperatorDecided, *, of_cell: bool) -> Decision:
    return Decision(
        event.time,
        event.who,
        event.answer,
        event.reason,
        event.hold or '',
        event.role,
        event.known,
        of_cell,
    )


def _begun(event: e.TaskStarted, beside: list[AtWork]) -> Attempt:
    return Attempt(
        event.section,
        event.task,
        RUNNING,
        name=event.name,
        component=event.component,
        round=event.round,
        attempt=event.attempt,
        started=event.time,
        args=event.args,
        beside=beside,
    )


def _end(attempt: Attempt, event: e.TaskSucceeded | e.TaskFailed) -> None:
    attempt.results = event.results
    if isinstance(event, e.TaskSucceeded):
        attempt.outcome = SUCCEEDED
    else:
        attempt.outcome, attempt.reason, attempt.message = FAILED, event.reason, event.message
        attempt.controller_said, attempt.last_feedback = event.controller_said, event.last_feedback
        attempt.topic_says = event.topic_says


def _passed(event: e.TaskSkipped | e.TaskMarkedDone | e.TaskContinued) -> Attempt:
    passed = Attempt(event.section, event.task, CONTINUED, ended=event.time)
    if isinstance(event, e.TaskSkipped):
        passed.outcome, passed.reason = SKIPPED, event.reason
    elif isinstance(event, e.TaskMarkedDone):
        passed.outcome, passed.results = MARKED_DONE, event.results
    else:
        passed.reason = event.policy
    return passed


def _note(attempt: Attempt, event: e.TaskEvent) -> None:
    if isinstance(event, e.TaskAdopted):
        attempt.adopted += 1
    elif isinstance(event, e.TaskResent):
        attempt.resent += 1
    elif isinstance(event, e.TaskCancelRequested):
        attempt.cancelled = event.cause


_FOLDS: Mapping[type[e.Event], Callable[[ItemFold, Any], None]] = {
    e.CycleStarted: ItemFold._cycle_started,  # noqa: SLF001 - its own
    e.ItemPlaced: ItemFold._stands,  # noqa: SLF001
    e.ItemMoved: ItemFold._stands,  # noqa: SLF001
    e.BeltIndexStarted: ItemFold._belt_starts,  # noqa: SLF001
    e.ItemMissing: ItemFold._ended,  # noqa: SLF001
    e.ItemRemoved: ItemFold._ended,  # noqa: SLF001
    e.PositionEnded: ItemFold._left,  # noqa: SLF001
    e.ItemIdentified: ItemFold._identified,  # noqa: SLF001
    e.ItemRejected: ItemFold._rejected,  # noqa: SLF001
    e.JobPaused: ItemFold._piece_waits,  # noqa: SLF001
    e.JobResumed: ItemFold._piece_decided,  # noqa: SLF001
    e.JobStopping: ItemFold._piece_decided,  # noqa: SLF001
    e.ItemNonconforming: ItemFold._nonconforming,  # noqa: SLF001
    e.HoldRaised: ItemFold._hold,  # noqa: SLF001
    e.HoldReleased: ItemFold._released,  # noqa: SLF001
    e.OperatorDecided: ItemFold._decided,  # noqa: SLF001
    e.OrchestratorStarted: ItemFold._restarted,  # noqa: SLF001
}
