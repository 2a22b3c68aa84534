"""A state as text, written in slices between settles, because a queue may be very long."""

from __future__ import annotations

import copy
import json
from collections import deque

from bt_orchestrator.base.errors import JournalFailed
from bt_orchestrator.model.keeping.snapshot import (
    Reader,
    Writer,
    state_from_plain,
    text_of_objects,
    text_of_state,
)
from bt_orchestrator.model.state import CellState, JobState
from bt_orchestrator.model.state.live_jobs import LiveJobs

SLICE = 250
"""Number of jobs of the queue written at once: some milliseconds."""


class StateText:
    """The state of one moment. The queue is written in slices, everything else at once.

    With `check` everything is read back, because events before it will be removed.
    """

    def __init__(self, state: CellState, *, check: bool = False) -> None:
        """Take the present state.

        :raises JournalFailed: the text would not restore the state
        """
        self.seq = state.seq
        self._cell = state.cell
        self._writer = Writer()
        self._queued = deque(state.jobs.queue())
        near = copy.copy(state)
        near.jobs = LiveJobs(state.jobs.line.values())
        self._fields = self._writer.fields_of(near)
        self._written = 0
        """How many objects are in the pieces."""
        self._pieces: list[str] = []
        self._read_back: Reader | None = None
        self._end_piece()
        if check:
            self._check(near)

    def go_on(self) -> bool:
        """Write the next jobs of the queue; returns whether that was all.

        :raises JournalFailed: the text would not restore one of them
        """
        jobs = [self._queued.popleft() for _ in range(min(SLICE, len(self._queued)))]
        places = {job.job.id: self._writer.write(JobState, job) for job in jobs}
        self._fields['jobs'].update(places)
        self._end_piece()
        if self._read_back is not None:
            for job in jobs:
                if self._read_back.read(JobState, places[job.job.id]) != job:
                    raise JournalFailed(
                        f'the state cannot be kept (job {job.job.id} would change)'
                    )
        return not self._queued

    @property
    def text(self) -> str:
        """The whole as JSON that can be written as UTF-8, once all is written."""
        return text_of_state(self._fields, self._pieces, self._cell)

    def _end_piece(self) -> None:
        piece = text_of_objects(self._writer.objects[self._written :])
        self._written = len(self._writer.objects)
        self._pieces.append(piece)
        if self._read_back is not None:
            self._read_back.add(json.loads(f'[{piece}]'))

    def _check(self, near: CellState) -> None:
        # Scripts never change, are also in their events, and are large.
        scripts = [*near.scripts.values(), *near.released_scripts.values()]
        known = {self._writer.place_of(type(script), script): script for script in scripts}
        again = vars(state_from_plain(near.cell, json.loads(self.text), known))
        differ = [
            name
            for name, value in vars(near).items()
            if name != 'preparations' and again[name] != value
        ]
        if differ:
            raise JournalFailed(f'the state cannot be kept ({", ".join(differ)} would change)')
        self._read_back = Reader(json.loads(f'[{self._pieces[0]}]'), known)
