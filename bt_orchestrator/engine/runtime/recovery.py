"""Taking over a cell from its journal at every start (semantics 9.2)."""

from __future__ import annotations

import hashlib
import json
import logging
from collections.abc import Iterable, Iterator
from functools import lru_cache
from importlib.resources import files
from typing import TYPE_CHECKING, NamedTuple

from bt_orchestrator import model
from bt_orchestrator.base.errors import DamagedRecord, JournalMismatch, JournalUnusable
from bt_orchestrator.engine.runtime.permits.service import without_component
from bt_orchestrator.engine.runtime.permits.surroundings import in_utc, taken_over, to_be_named
from bt_orchestrator.model import events as e
from bt_orchestrator.model.by import Control
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.fold import apply
from bt_orchestrator.model.keeping.snapshot import state_from_plain
from bt_orchestrator.model.limits import listed
from bt_orchestrator.model.packml import PackmlState, UnitMode
from bt_orchestrator.model.state import CellState
from bt_orchestrator.model.stop_reason import MISSING, RESTARTED, RESTORED
from bt_orchestrator.model.words import sentence
from bt_orchestrator.ports import EventStore, Snapshot

if TYPE_CHECKING:
    from importlib.abc import Traversable  # its place depends on the version of Python

log = logging.getLogger(__name__)

_UNREADABLE = (AttributeError, IndexError, KeyError, TypeError, ValueError)
"""Errors that reading a damaged state, or one of another program version, may raise."""


def restore(cell: Cell, store: EventStore) -> CellState:
    """Return the state at the end of the journal: a snapshot, and the events after it.

    A snapshot only saves time. An unusable one is ignored, and the events are replayed from the
    beginning. If a record is damaged the result is the state before its commit, unless there is a
    later snapshot; then also one of another program version is accepted.

    :raises JournalMismatch: there is unfinished work, and the cell is not the one it was begun on
    :raises JournalUnusable: the journal cannot be read
    """
    for snapshot in store.snapshots():
        state = _from_snapshot(cell, snapshot, store)
        if state is not None:
            return state
    beginning = store.beginning()
    state = CellState(cell) if beginning is None else _begin_whole(cell, beginning, store)
    is_whole = _replay(state, store.read(state.seq))
    return state if is_whole else _past_the_damage(state, store)


def _begin_whole(cell: Cell, beginning: Snapshot, store: EventStore) -> CellState:
    """Return the state that replay begins with, and that nothing else can take the place of."""
    state = begin_with(cell, beginning)
    try:
        _know_used_ids(state, store)
    except KeyError as error:
        raise JournalUnusable(
            f'the journal has lost order ids or serials that were used before event {state.seq}, '
            'so it would not be noticed if one is used again: both copies of a part of them are '
            'damaged; restore a backup of the journal'
        ) from error
    return state


def _past_the_damage(state: CellState, store: EventStore) -> CellState:
    """Return a later state from a snapshot of another program version; if none, this one."""
    for snapshot in store.snapshots():
        if snapshot.seq <= state.seq:
            continue
        try:
            later = begin_with(state.cell, snapshot)
            _know_used_ids(later, store)
            _replay(later, store.read(later.seq))
        except (JournalMismatch, KeyError) as error:
            log.warning('the snapshot at event %d is ignored: %s', snapshot.seq, error)
        else:
            return later
    return state


def stamp(cell: Cell) -> str:
    """Return an id of program and cell for a snapshot; with another id, events are replayed.

    The program's part is a digest of the source of its rules: no version has to be incremented by
    hand when the fold or the state changes.
    """
    return f'{_program()}-{digest(cell)}'


@lru_cache(maxsize=1)
def _program() -> str:
    return program_in(files(model))


def program_in(folder: Traversable) -> str:
    """Return a digest of all source files in and below a folder."""
    rules = hashlib.sha256()
    for name, text in _sources(folder):
        rules.update(f'{name} {len(text)} '.encode() + text)
    return rules.hexdigest()[:16]


def _sources(folder: Traversable, within: str = '') -> Iterator[tuple[str, bytes]]:
    """Yield the path and the text of every source file, in a fixed order."""
    for entry in sorted(folder.iterdir(), key=lambda entry: entry.name):
        path = f'{within}/{entry.name}'
        if entry.is_dir():
            yield from _sources(entry, path)
        elif entry.name.endswith('.py'):
            yield path, entry.read_bytes()


def _from_snapshot(cell: Cell, snapshot: Snapshot, store: EventStore) -> CellState | None:
    if snapshot.stamp != stamp(cell):
        log.info('the snapshot at event %d is of another program or cell', snapshot.seq)
        return None
    try:
        state = state_from_plain(cell, json.loads(snapshot.state))
        _know_used_ids(state, store)
        _replay(state, store.read(state.seq))
    except (*_UNREADABLE, JournalMismatch) as error:
        log.warning('the snapshot at event %d is ignored: %r', snapshot.seq, error)
        return None
    return state


def begin_with(cell: Cell, beginning: Snapshot) -> CellState:
    try:
        return state_from_plain(cell, json.loads(beginning.state))
    except _UNREADABLE as error:
        raise JournalMismatch(
            f'the journal begins with a state, at event {beginning.seq}, that does not fit cell '
            f'{cell.name} or this program ({error!r}); name the cell file and use the program '
            'that it was written with'
        ) from error


def _know_used_ids(state: CellState, store: EventStore) -> None:
    """Take in the ids of orders, and the serials, that the state only names.

    :raises KeyError: some are lost
    """
    for ids in (state.order_ids, state.serials):
        ids.open_parts(store.used_ids)


def _replay(state: CellState, events: Iterable[e.Event]) -> bool:
    """Apply events as far as they can be read; return whether those were all."""
    damaged = False
    try:
        for event in events:
            _refuse_gap(state, event)
            apply(state, event)
    except DamagedRecord as damage:
        log.error('%s; the state is that of event %d', damage, state.seq)
        damaged = True
    except (AssertionError, KeyError) as error:
        raise JournalMismatch(
            f'the journal does not fit cell {state.cell.name}: event {state.seq + 1} cannot have '
            f'happened there ({error!r}); name the cell file that it was written with'
        ) from error
    if state.cell_digest == digest(state.cell):
        return not damaged
    if state.jobs:
        unfinished = listed(state.jobs, 'none')
        raise JournalMismatch(
            f'the journal holds unfinished jobs ({unfinished}) and the cell file has changed '
            'since they began; run them to their end with the file as it was'
        )
    if state.unit_mode is UnitMode.MANUAL:
        raise JournalMismatch(
            'the cell is in manual mode and the cell file has changed since; end manual mode with '
            'the file as it was'
        )
    return not damaged


def _refuse_gap(state: CellState, event: e.Event) -> None:
    if event.seq > state.seq + 1:
        raise DamagedRecord(state.seq + 1, event.seq - 1, 'not there')


class Found(NamedTuple):
    """The facts that a new orchestrator finds in its journal."""

    history: str
    is_copy: bool
    """It was restored from a backup, and no node has worked on it since."""
    missing: str
    """The missing events, in words; empty: none."""
    seq: int
    """Its last event."""
    time: str
    """When that happened."""

    @classmethod
    def of(cls, state: CellState, store: EventStore) -> Found:
        """Look at a journal; if events are missing it goes on as a history of its own."""
        is_copy = store.is_restored and store.history != state.history
        missing = store.missing(state.seq)
        if missing:
            log.error('%s', missing)
            store.go_on_after(state.seq)
        return cls(store.history, is_copy, missing, state.seq, in_utc(state.time))


def take_over(
    state: CellState, journal: Found, boot: str, *, auto_resume: bool, to_remote: bool = False
) -> Iterator[e.Event]:
    """Record the start of a new orchestrator, and what it found.

    :param journal: its journal
    :param boot: boot id of its machine; empty: not known
    :param auto_resume: continue at once; otherwise start nothing until an operator has checked the
        line and releases the hold `restarted`, which is independent of other holds
    :param to_remote: whoever starts the node takes control from the panels (semantics 7.8)
    """
    yield e.OrchestratorStarted(
        cell=state.cell.name,
        digest=digest(state.cell),
        history=journal.history,
        restored=journal.is_copy,
        missing=journal.missing,
        boot=boot,
        cell_definition=state.cell,
    )
    if to_remote and state.control is not Control.REMOTE:
        yield e.ControlChanged(control=Control.REMOTE.value, reason='the node was started so')
    yield from taken_over(state)
    yield from without_component(state)
    for name, component in state.cell.components.items():
        if component.state is not None and state.readings[name].ready:
            yield e.ComponentStateChanged(component=name, ready=False)  # no message yet
    goals = sum(task.goal is not None for task in state.running.values())
    waits = [hold for hold in state.pauses if hold.reason == RESTARTED]
    if auto_resume:
        yield from (e.HoldReleased(hold=hold.id) for hold in waits)
    unfinished = sentence('unfinished', jobs=len(state.jobs), goals=goals)
    ends = {'seq': journal.seq, 'time': journal.time, 'words': unfinished}
    if journal.is_copy:
        looked_at = sentence('restored', **ends)
        besides = f'; {journal.missing}' if journal.missing else ''
        yield to_be_named(state, RESTORED, f'{looked_at}{besides}')
    elif journal.missing:
        yield to_be_named(state, MISSING, sentence('missing', what=journal.missing, **ends))
    elif state.jobs and not auto_resume and not waits and _would_go_on(state):
        yield to_be_named(state, RESTARTED, unfinished)


_STANDS = (
    *(PackmlState.STOPPED, PackmlState.RESETTING, PackmlState.IDLE),
    *(PackmlState.ABORTING, PackmlState.ABORTED, PackmlState.CLEARING),
)


def _would_go_on(state: CellState) -> bool:
    """Tell whether the cell would start anything without a command."""
    return state.packml not in _STANDS or state.wish is None
