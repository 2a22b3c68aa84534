"""What holds of queue and jobs in every run, checked by a fold of its own."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import inf
from typing import ClassVar

from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Cell, Release, Start

PROGRESS = (e.TaskStarted, e.CycleStarted)


class QueueInvariants:
    """Follows the events of one cell and raises AssertionError at the first that cannot be."""

    def __init__(self, cell: Cell) -> None:
        self._waits_count = cell.start is Start.BINDING
        self._terms: dict[str, tuple[int, float]] = {}
        """The smaller the more urgent."""
        self._by_hand: set[str] = set()
        """Jobs whose place a person chose."""
        self._early: dict[str, float] = {}
        """Jobs that wait for their start."""
        self._wished: str | None = ''
        """The job that the last command lets start."""
        self._ids: set[str] = set()
        self._queue: list[str] = []
        self._held: set[str] = set()
        self._lacks: dict[str, set[str]] = {}
        """Components out of service that queued jobs need (7.5); none is empty."""
        self._released = cell.release is Release.AUTOMATIC
        self._generated: dict[str, str] = {}
        """Digests of jobs whose scripts are not released (6.10)."""
        self._releases: set[str] = set()
        self._running: list[str] = []
        self._fed = ''
        """The job of the last item that was begun."""
        self._begins_nothing: set[str] = set()
        """Jobs that are paused, or end."""
        self._stopped = ''
        """The job that was stopped last."""
        self._quantity: dict[str, int] = {}
        self._items: dict[str, list[str]] = {}
        self._stop_after = ''
        self._ended: dict[str, dict[str, int]] = {}

    def take(self, event: e.Event) -> None:
        """Take in the next event."""
        for kind, take in self._takers.items():
            if isinstance(event, kind):
                take(self, event)
        assert len(self._ids) == len(self._queue) + len(self._running) + len(self._ended), event

    # --- the queue --------------------------------------------------------------------------

    def _queued(self, event: e.JobQueued) -> None:
        assert event.job not in self._ids, event
        self._ids.add(event.job)
        at = len(self._queue) if event.position is None else event.position - 1
        self._note(event)
        if event.ranked:
            assert at == self._place(event.job), (event, self._queue)
        else:
            self._by_hand.add(event.job)
        self._queue.insert(at, event.job)
        if event.held:
            self._held.add(event.job)
        if event.rest_of:
            self._is_rest(event)
        self._quantity[event.job] = event.quantity
        self._items[event.job] = []

    def _is_rest(self, event: e.JobQueued) -> None:
        """A rest comes first, with all that its job has not begun and begins no more (7.6)."""
        of = event.rest_of
        assert (event.position, event.held) == (1, False), event
        assert of in self._running, event
        assert self._stopped == of, event
        assert event.quantity == self._quantity[of] - len(self._items[of]) > 0, event

    def _note(self, event: e.JobQueued | e.JobUpdated) -> None:
        """Note how urgent a job is, and whether it waits for its start (6.7)."""
        same = event.job in self._terms and self._terms[event.job][1] == (event.start or inf)
        is_rest = isinstance(event, e.JobQueued) and event.rest_of
        comes = self._waits_count and not is_rest and (event.start or 0.0) > event.time
        assert event.awaits_start == (event.job in self._early if same else comes), event
        self._early.pop(event.job, None)
        self._lacks.pop(event.job, None)
        self._generated.pop(event.job, None)
        if event.awaits_release:
            assert event.recipe, event
            assert event.digest not in self._releases, event
            self._generated[event.job] = event.digest
        elif event.recipe and isinstance(event, e.JobQueued):
            assert self._released or event.digest in self._releases, event
        if event.unavailable:
            self._lacks[event.job] = set(event.unavailable)
        if event.awaits_start:
            assert event.start is not None
            self._early[event.job] = event.start
        self._terms[event.job] = -event.priority, event.start or inf

    def _script_released(self, event: e.ScriptReleased) -> None:
        assert event.digest not in self._releases, event
        self._releases.add(event.digest)
        self._generated = {
            n: digest for n, digest in self._generated.items() if digest != event.digest
        }

    def _out_of_service(self, event: e.ComponentOutOfService) -> None:
        for job in event.jobs:
            self._lacks.setdefault(job, set()).add(event.component)

    def _in_service(self, event: e.ComponentInService) -> None:
        lacks = {job: lack - {event.component} for job, lack in self._lacks.items()}
        self._lacks = {job: lack for job, lack in lacks.items() if lack}

    def _place(self, job: str) -> int:
        """Return the place, from 0: before the first that is less urgent and not put by hand."""
        for at, other in enumerate(self._queue):
            if other not in self._by_hand and self._terms[other] > self._terms[job]:
                return at
        return len(self._queue)

    def _commanded(self, event: e.OperatorDecided) -> None:
        self._wished = event.job if event.answer in ('release', 'next') else None

    def _may_start(self, event: e.JobMayStart) -> None:
        start = self._early.pop(event.job)
        assert start <= event.time or event.job == self._wished, event

    def _moved(self, event: e.JobMoved) -> None:
        self._by_hand.add(event.job)
        self._queue.remove(event.job)
        self._queue.insert(event.position - 1, event.job)
        assert self._queue[event.position - 1] == event.job, event

    def _arranged(self, event: e.QueueArranged) -> None:
        """Places that a person chose stay, and nobody comes or goes (6.7)."""
        arranged = [*event.jobs, *self._queue[len(event.jobs) :]]
        assert sorted(arranged) == sorted(self._queue) != [], event
        changed = {job for job, old in zip(arranged, self._queue, strict=True) if job != old}
        assert changed.isdisjoint(self._by_hand), (event, self._queue)
        self._queue = arranged

    def _updated(self, event: e.JobUpdated) -> None:
        at, before = self._queue.index(event.job), self._terms[event.job]
        self._quantity[event.job] = event.quantity
        self._note(event)
        if event.job not in self._by_hand and self._terms[event.job] != before:
            self._queue.remove(event.job)
            at = self._place(event.job)
            self._queue.insert(at, event.job)
            assert event.position == at + 1, (event, self._queue)
        else:
            assert event.position is None, event

    def _hold(self, event: e.JobHeld) -> None:
        assert event.job in set(self._queue) - self._held, event
        self._held.add(event.job)

    def _release(self, event: e.JobReleased) -> None:
        self._held.remove(event.job)

    def _removed(self, event: e.JobRemoved) -> None:
        self._lacks.pop(event.job, None)
        self._generated.pop(event.job, None)
        self._queue.remove(event.job)
        self._held.discard(event.job)
        self._early.pop(event.job, None)
        self._ended[event.job] = {}

    def _stop_requested(self, event: e.QueueStopRequested) -> None:
        self._stop_after = event.after

    def _stop_over(self, event: e.QueueStopReached | e.QueueStopCancelled) -> None:
        if isinstance(event, e.QueueStopReached):
            assert not self._running or event.after == 'item', event
        self._stop_after = ''

    # --- the line ---------------------------------------------------------------------------

    def _started(self, event: e.JobStarted) -> None:
        # A job that was aborted in the queue may still have to skip its initialization.
        waits = self._early.keys() | self._lacks.keys() | self._generated.keys()
        passed = self._held | self._begins_nothing | waits
        first = next(job for job in self._queue if job not in passed)
        assert event.job == first, (event, self._queue)
        assert not self._stop_after, event
        self._queue.remove(event.job)
        self._running.append(event.job)

    def _progress(self, event: e.TaskStarted | e.CycleStarted) -> None:
        assert event.job is None or event.job in self._running, event
        if isinstance(event, e.CycleStarted) and event.item not in self._items[event.job]:
            self._begun(event)

    def _begun(self, event: e.CycleStarted) -> None:
        """Take in an item: items of jobs come in the order in which the jobs started."""
        assert event.job not in self._begins_nothing, event
        assert self._stop_after != 'item', event
        if self._fed in self._running:
            assert self._running.index(self._fed) <= self._running.index(event.job), event
        self._fed = event.job
        self._items[event.job].append(event.item)
        assert len(self._items[event.job]) <= self._quantity[event.job], event

    def _ending(self, event: e.JobPaused | e.JobStopping | e.JobAborting) -> None:
        self._begins_nothing.add(event.job)
        self._stopped = event.job if isinstance(event, e.JobStopping) else ''
        if isinstance(event, e.JobAborting):
            self._early.pop(event.job, None)
            self._lacks.pop(event.job, None)
            self._generated.pop(event.job, None)

    def _resumed(self, event: e.JobResumed) -> None:
        self._begins_nothing.remove(event.job)

    def _end(self, event: e.JobCompleted | e.JobAborted) -> None:
        jobs = self._running if event.job in self._running else self._queue
        jobs.remove(event.job)
        self._held.discard(event.job)
        begun = len(self._items[event.job])
        assert event.counts['started'] == begun, event
        all_done = begun == self._quantity[event.job]
        status = 'completed' if all_done else 'stopped'
        assert event.exit_status == ('aborted' if isinstance(event, e.JobAborted) else status)
        self._ended[event.job] = dict(event.counts)

    _takers: ClassVar[Mapping[type[e.Event] | tuple[type[e.Event], ...], Callable[..., None]]] = {
        e.JobQueued: _queued,
        e.JobMoved: _moved,
        e.QueueArranged: _arranged,
        e.JobUpdated: _updated,
        e.OperatorDecided: _commanded,
        e.JobMayStart: _may_start,
        e.JobHeld: _hold,
        e.JobReleased: _release,
        e.JobRemoved: _removed,
        e.QueueStopRequested: _stop_requested,
        (e.QueueStopReached, e.QueueStopCancelled): _stop_over,
        e.JobStarted: _started,
        PROGRESS: _progress,
        (e.JobPaused, e.JobStopping, e.JobAborting): _ending,
        e.JobResumed: _resumed,
        (e.JobCompleted, e.JobAborted): _end,
        e.ScriptReleased: _script_released,
        e.ComponentOutOfService: _out_of_service,
        e.ComponentInService: _in_service,
    }
