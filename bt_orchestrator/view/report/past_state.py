"""The state of a cell at a past moment, folded from a journal as the engine folds it."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import chain

from bt_orchestrator.base.errors import NotKept
from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.codec import from_plain, from_record
from bt_orchestrator.model.fold import apply
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.model.keeping.snapshot import state_from_plain
from bt_orchestrator.model.state import CellState
from bt_orchestrator.ports import Records
from bt_orchestrator.view.report.reading import Reading

MISFITS = (AssertionError, AttributeError, IndexError, KeyError, TypeError, ValueError)
"""Errors that states and events may raise which do not fit the cell, or this program."""

_STARTS = Wanted(events=(e.OrchestratorStarted.event,))


def state_at(
    records: Records,
    cell: Cell,
    seq: int,
    before: Callable[[CellState, e.Event], None] = lambda _state, _event: None,
) -> CellState:
    """Return the state after an event.

    :param cell: as its file said it then
    :param before: called with each event before it changes the state
    :raises NotKept: the event is not in the journal, or it was another cell then
    """
    _, first, last = records.extent()
    if not 0 < seq <= last:
        raise NotKept(f'event {seq} is not in the journal: it has events {first} to {last}')
    start = records.state_before(seq)
    try:
        state = CellState(cell)
        if start is not None:
            state = state_from_plain(cell, json.loads(start.state))
        if state.seq + 1 < first and state.seq < seq:
            raise NotKept(
                f'event {seq} cannot be had any more: the journal begins with event {first}, '
                'and keeps no state before it'
            )
        for event in _events(records, state.seq, seq):
            before(state, event)
            apply(state, event)
    except MISFITS as error:
        raise NotKept(
            f'the journal does not fit cell {cell.name} at event {seq} ({error!r}): '
            'name the cell file as it was then'
        ) from error
    return state


def _events(records: Records, after: int, until: int) -> Iterator[e.Event]:
    """Yield the events between, all of them.

    :raises NotKept: one is damaged, or not there
    """
    wanted = Wanted(after_seq=after, before_seq=until + 1)
    while True:
        page = records.page(wanted)
        for damage in page.damage:
            raise NotKept(f'event {until} cannot be had: {damage.what}')
        yield from (from_record(json.loads(record.text)) for record in page.records)
        if page.is_last:
            return
        wanted = page.rest


def cell_at(reading: Reading, seq: int) -> Cell | None:
    """Return the cell at an event, as its file said it then; None: the journal has not got it.

    Programs that write it note it at every start, and with every state that is kept.
    """
    kept = reading.records.state_before(seq)
    plain = {'state': {}} if kept is None else json.loads(kept.state)
    since = 0 if kept is None else kept.seq
    between = replace(_STARTS, after_seq=since, before_seq=seq + 1, newest_first=True)
    start = reading.first(between)
    known = plain['state'].get('cell_digest', '')
    digest = start.digest if isinstance(start, e.OrchestratorStarted) else known
    if digest == known and 'cell' in plain:
        return from_plain(Cell, plain['cell'])
    for event in chain((start,), reading.events(_STARTS)):
        if (
            isinstance(event, e.OrchestratorStarted)
            and event.digest == digest
            and event.cell_definition
        ):
            return event.cell_definition
    return None
