"""Journals that are damaged: what a node left, what was so, and older copies of the same files."""

from __future__ import annotations

import json
import shutil
import sqlite3
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path

from fakes.line import THREE, Line
from fakes.long_journal import LongRun

from bt_orchestrator.engine.runtime import housekeeping
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.fold import apply
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.keeping.snapshot import state_to_plain
from bt_orchestrator.model.state import CellState

NAME = 'journal.sqlite3'
ENDINGS = ('', '-wal', '-mark')
"""Of the files that are damaged: the journal, its log, its mark."""

_SNAPSHOT_EVERY = 150
"""Events: some stand before the last snapshot, and some after it."""


class Scene:
    """A journal as a node left it."""

    def __init__(self, folder: Path, older: Path, events: Sequence[Event]) -> None:
        """Describe it.

        :param older: a folder with copies of its files from before
        :param events: all that were committed
        """
        self.folder = folder
        self.older = older
        self.events = events

    def copy(self, folder: Path) -> Path:
        """Copy the files to a new folder; returns the path of the journal there."""
        shutil.copytree(self.folder, folder)
        return folder / NAME

    def state_at(self, seq: int) -> str | None:
        """Return what was so after an event; None: there was no such event."""
        return self._states.get(seq)

    @cached_property
    def _states(self) -> dict[int, str]:
        state = CellState(Line().cell)
        states = {0: frozen(state)}
        for event in self.events:
            apply(state, event)
            states[event.seq] = frozen(state)
        return states


def frozen(state: CellState) -> str:
    """Return all of a state as a text, to be compared."""
    return json.dumps(state_to_plain(state))


def make_scenes(folder: Path) -> list[Scene]:
    """Make a journal whose node was killed at work, the same without a log, and one closed."""
    every, housekeeping.SNAPSHOT_EVERY = housekeeping.SNAPSHOT_EVERY, _SNAPSHOT_EVERY
    try:
        killed = _killed(folder / 'killed')
        return [killed, _merged(killed, folder / 'merged'), _ended(folder / 'ended')]
    finally:
        housekeeping.SNAPSHOT_EVERY = every


def _killed(folder: Path) -> Scene:
    path = folder / 'written' / NAME
    _closed_run(path, 'A')
    _save(path, folder / 'older')
    run = LongRun(path)
    run.job('B', 10)
    run.rest(3)
    assert run.orchestrator.ask(_order(run, 'C')).accepted
    run.go(lambda: len(run.orchestrator.state.items) == 3)
    _save(path, folder / 'left')
    events = list(run.store.read())
    run.kill()
    return Scene(folder / 'left', folder / 'older', events)


def _merged(killed: Scene, folder: Path) -> Scene:
    """Let another program open and close the journal: SQLite moves the log into it."""
    path = killed.copy(folder / 'left')
    database = sqlite3.connect(path)
    database.execute('SELECT count(*) FROM events').fetchone()
    database.close()
    assert not path.with_name(f'{NAME}-wal').exists()
    return Scene(folder / 'left', killed.older, killed.events)


def _ended(folder: Path) -> Scene:
    path = folder / 'written' / NAME
    _closed_run(path, 'A')
    _save(path, folder / 'older')
    _closed_run(path, 'B')
    _save(path, folder / 'left')
    run = LongRun(path)
    events = list(run.store.read())
    run.kill()
    return Scene(folder / 'left', folder / 'older', events)


def _closed_run(path: Path, job: str) -> None:
    run = LongRun(path)
    run.job(job, 10)
    run.job(f'{job}-2', 5)
    run.close()


def _order(run: LongRun, name: str) -> AddJobs:
    return AddJobs((Job(name, run.line.script(THREE), 6),))


def _save(path: Path, folder: Path) -> None:
    folder.mkdir()
    for ending in ENDINGS:
        file = path.with_name(path.name + ending)
        if file.exists():
            shutil.copy(file, folder)
