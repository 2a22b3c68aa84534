"""Keeping the journal short for the next start: snapshots and retention.

None of it is on the way of a goal: it is done between settles, best when nothing happens, and in
small pieces. If it fails the cell goes on; only the next start takes longer.
"""

from __future__ import annotations

import logging

from bt_orchestrator.model.history import record_of
from bt_orchestrator.model.state import CellState
from bt_orchestrator.model.state_text import StateText
from bt_orchestrator.ports import Journal, Snapshot
from bt_orchestrator.runtime.recovery import stamp

log = logging.getLogger(__name__)

SNAPSHOT_EVERY = 1000
"""Events after which a quiet moment is used for a snapshot."""

SNAPSHOT_AT_LATEST = 5000
"""Events after which a snapshot is made on a line that is never quiet."""

KEEP_JOBS = 1000
"""How many ended jobs keep their events, unless somebody says otherwise."""

KEEP_ALL = -1


class Housekeeping:
    """Snapshots of one cell's state, and the end of old events. Called from the tick thread."""

    def __init__(self, state: CellState, journal: Journal, keep_jobs: int = KEEP_JOBS) -> None:
        """Look after a journal.

        :param keep_jobs: how many ended jobs keep their events, at least; KEEP_ALL: all
        """
        self._state = state
        self._journal = journal
        self._keep_jobs = keep_jobs
        self._stamp = stamp(state.cell)
        self._saved_seq = max(
            (one.seq for one in journal.snapshots() if one.stamp == self._stamp), default=0
        )
        self._noted: set[str] = set()
        self._remove_before = 0
        self._text: StateText | None = None
        """A snapshot that is being written."""
        self._first = 0
        """Event with which the journal begins once that is kept; 0: as before."""
        self._failed_seq = 0
        """Where it failed last; it is tried again when something has happened since."""

    def turn(self, *, quiet: bool) -> None:
        """Do one small piece of what is due; the state is durable.

        :param quiet: nothing happens at this moment
        """
        if self._state.seq == self._failed_seq:
            return
        behind = self._state.seq - max(self._saved_seq, self._failed_seq)
        try:
            if self._text is not None:
                self._go_on(self._text)
            elif behind >= max(SNAPSHOT_AT_LATEST, self._worth):
                self._begin()
            elif quiet:
                self._at_leisure(behind)
        except Exception as error:  # noqa: BLE001 - whatever it is, the cell goes on
            log.warning('%s: no snapshot, nothing removed; tried again later', error)
            self._failed_seq, self._text, self._remove_before = self._state.seq, None, 0

    def finish(self) -> None:
        """Leave a snapshot to the next start."""
        try:
            if self._state.seq > self._saved_seq:
                text = StateText(self._state)
                while not text.go_on():
                    pass
                self._save(text)
        except Exception as error:  # noqa: BLE001 - the node ends all the same
            log.warning('%s: the next start replays more events', error)

    def _at_leisure(self, behind: int) -> None:
        ended = self._state.ended.keys() - self._noted
        if behind >= (0 if ended else SNAPSHOT_EVERY) and behind >= self._worth:
            self._begin(self._first_needed() if ended else 0)
        elif self._remove_before and not self._journal.remove_batch(self._remove_before):
            self._remove_before = 0

    @property
    def _worth(self) -> int:
        """Events that are worth a snapshot: it takes as long as to replay one for each job queued.

        So a job that ends in front of a long queue does not have all of it written.
        """
        return self._state.jobs.waiting

    def _begin(self, first: int = 0) -> None:
        """Begin to write a snapshot.

        :param first: event before which all others are to be removed then; 0: none are
        """
        self._first = first
        self._text = StateText(self._state, check=first > 0)
        self._go_on(self._text)

    def _go_on(self, text: StateText) -> None:
        """Write as much as can be done at once."""
        if not text.go_on():
            return
        self._text = None
        snapshot = self._save(text)
        if self._first:
            self._journal.begin_with(snapshot)
            self._remove_before = self._first

    def _save(self, text: StateText) -> Snapshot:
        ended = [job for name, job in self._state.ended.items() if name not in self._noted]
        snapshot = Snapshot(text.seq, self._stamp, text.text)
        self._journal.save(snapshot, [record_of(job) for job in ended])
        self._saved_seq = text.seq
        self._noted = set(self._state.ended)
        return snapshot

    def _first_needed(self) -> int:
        """Return the first event that has to stay; 0: those before it are gone, or all stay."""
        if self._keep_jobs == KEEP_ALL:
            return 0
        first = self._journal.first_needed(self._state.jobs.keys(), self._keep_jobs)
        return first if first > self._journal.first_seq() else 0
