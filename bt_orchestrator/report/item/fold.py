"""The fold from events to the record of one item."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from bt_orchestrator.model import events as e
from bt_orchestrator.model.hold_words import held_words
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.task_spans import TaskSpans
from bt_orchestrator.report.intervals import Span, gaps
from bt_orchestrator.report.item.history import (
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
from bt_orchestrator.report.item.scene import Film
from bt_orchestrator.report.item.why import Next, Scripts, waits


def _no_script(_: str) -> Script | None:
    return None


class ItemFold:
    """Takes in all events from some time before an item on, in order.

    Those of its job alone are enough for what happened to it, without the reasons of its waits.
    """

    def __init__(self, item: str, job: str, scripts: Scripts = _no_script) -> None:
        self.history = ItemHistory(item, job)
        self._scripts = scripts
        self._spans = TaskSpans()
        self._film = Film()
        self._open: dict[e.TaskKey, Attempt] = {}
        self._ends: list[tuple[e.TaskKey, float]] = []
        """When tasks of the item ended, or were passed."""
        self._time = 0.0

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
        if isinstance(event, e.OrderEvent):
            if event.job == history.job:
                _order(history, event)
        elif isinstance(event, e.TaskEvent):
            self._others(event)
            if event.item == history.item:
                self._task(event)
        else:
            fold = _FOLDS.get(type(event))
            if fold is not None:
                fold(self, event)
        self._film.follow(event)
        self._time = event.time

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
        if self._is_mine(event):
            self._end_stay(event.time)
            self.history.stays.append(Stay(event.section, event.time))
            if isinstance(event, e.ItemPlaced):
                self.history.lots = event.lots

    def _belt_starts(self, event: e.BeltIndexStarted) -> None:
        self._end_stay(event.time)

    def _ended(self, event: e.ItemMissing | e.ItemRemoved) -> None:
        if self._is_mine(event):
            self._end_stay(event.time)
            self.history.ended = event.time
            self.history.idle = self._idle(event.time)
            self.history.how = event.how if isinstance(event, e.ItemRemoved) else 'missing'

    def _idle(self, ended: float) -> list[Waited]:
        """Return what the item waited for while it had no task to wait for, as once rejected."""
        history = self.history
        if history.started is None:
            return []
        told = [Span(w.start, w.end) for one in history.tasks for w in one.waited]
        task = Next.none(history.job, history.item)
        return [
            waited
            for gap in gaps(Span(history.started, ended), [*told, *history.work])
            for waited in waits(self._film, gap.start, gap.end, task, self._scripts)
        ]

    def _identified(self, event: e.ItemIdentified) -> None:
        if self._is_mine(event):
            self.history.serial = event.serial

    def _rejected(self, event: e.ItemRejected) -> None:
        if self._is_mine(event):
            self.history.rejected = event.reason

    def _nonconforming(self, event: e.ItemNonconforming) -> None:
        if self._is_mine(event):
            self.history.nonconforming.append(event.task)

    def _end_stay(self, time: float) -> None:
        stay = self.history.stays[-1] if self.history.stays else None
        if stay is None or stay.until is not None:
            return
        stay.until = time
        others = self._film.now.slots.items()
        stay.beside = tuple(
            Neighbour(section, item) for section, item in others if item != self.history.item
        )

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
        is_mine = event.item == self.history.item
        of_hold = event.hold is not None and any(h.id == event.hold for h in self.history.holds)
        of_cell = not is_mine and (event.job, event.item, event.component) == (None,) * 3
        if is_mine or of_hold or (of_cell and event.hold is None and self._is_there):
            self.history.decisions.append(_decision(event, of_cell=of_cell and not of_hold))

    def _restarted(self, event: e.OrchestratorStarted) -> None:
        if self._is_there:
            words = 'the journal was brought back from a copy' if event.restored else event.missing
            self.history.restarts.append(Restart(event.time, self._time, words))

    # --- attempts ---------------------------------------------------------------------------

    def _others(self, event: e.TaskEvent) -> None:
        """Note at each attempt that runs what else runs."""
        if not isinstance(event, e.TaskStarted):
            return
        for key, attempt in self._open.items():
            if key != event.key:
                attempt.beside.append(_at_work(event))
        if event.item == self.history.item:
            running = self._film.now.running.values()
            beside = [_at_work(one) for one in running if one.key != event.key]
            self._open[event.key] = _begun(event, beside)

    def _task(self, event: e.TaskEvent) -> None:
        span = self._spans.follow(event)
        attempt = self._open.get(event.key)
        if isinstance(event, e.TaskStarted):
            assert attempt is not None
            task = Next(event.key, event.component)
            begin = self._ready(event)
            attempt.waited = waits(self._film, begin, event.time, task, self._scripts)
            self.history.tasks.append(attempt)
        elif isinstance(event, (e.TaskSucceeded, e.TaskFailed)):
            self._open.pop(event.key, None)
            if attempt is None:
                attempt = Attempt(event.section, event.task, RUNNING)
                self.history.tasks.append(attempt)
            attempt.attempt, attempt.ended = event.attempt, event.time
            attempt.seconds = span.seconds if span else None
            _end(attempt, event)
            self._ends.append((event.key, event.time))
        elif isinstance(event, (e.TaskSkipped, e.TaskMarkedDone, e.TaskContinued)):
            self.history.tasks.append(_passed(event))
            if isinstance(event, e.TaskContinued) and event.nonconforming:
                self.history.nonconforming.append(event.task)
            self._ends.append((event.key, event.time))
        elif attempt is not None:
            _note(attempt, event)

    def _ready(self, event: e.TaskStarted) -> float:
        """Return when everything was done that comes before a task of the item."""
        script = self._scripts(self.history.job)
        before = [time for key, time in self._ends if not _is_beside(script, key, event.key)]
        begun = self.history.started
        return max(before or [event.time if begun is None else begun])


def _is_beside(script: Script | None, one: e.TaskKey, other: e.TaskKey) -> bool:
    """Tell whether two tasks are in different tracks of one step."""
    if script is None or one.section != other.section:
        return False
    if one.task not in script.tasks or other.task not in script.tasks:
        return False
    tracks = script.step_of(other.task).tracks
    places = [
        next((n for n, track in enumerate(tracks) if any(t.id == key.task for t in track)), None)
        for key in (one, other)
    ]
    return places[0] is not None and places[0] != places[1]


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


def _at_work(event: e.TaskStarted) -> AtWork:
    return AtWork(event.component, event.name, event.item or '', event.section)


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
    e.ItemIdentified: ItemFold._identified,  # noqa: SLF001
    e.ItemRejected: ItemFold._rejected,  # noqa: SLF001
    e.ItemNonconforming: ItemFold._nonconforming,  # noqa: SLF001
    e.HoldRaised: ItemFold._hold,  # noqa: SLF001
    e.HoldReleased: ItemFold._released,  # noqa: SLF001
    e.OperatorDecided: ItemFold._decided,  # noqa: SLF001
    e.OrchestratorStarted: ItemFold._restarted,  # noqa: SLF001
}
