"""What readers and copies say is held against the journal."""

from __future__ import annotations

from typing import Any

import pytest
from chaos.copying import BACKUP, READ, digest_of
from chaos.witnesses import bad_copies, misled, vanished

ROWS = [(n, f'{{"seq": {n}}}') for n in range(1, 6)]


def record(seq: int, event: str = 'task.started', **more: Any) -> dict[str, Any]:
    return {'seq': seq, 'event': event, **more}


def begun(seq: int, history: str) -> dict[str, Any]:
    return record(seq, 'orchestrator.started', history=history)


def copy(events: int, **more: Any) -> dict[str, Any]:
    content = {'check': 'ok', 'events': events, 'digest': digest_of(ROWS[:events])}
    return {'kind': BACKUP, **content, **more}


JOURNAL = [record(1), record(2), record(3)]


def test_what_is_in_the_journal_has_not_vanished() -> None:
    assert list(vanished(JOURNAL, JOURNAL[1:], 'A')) == []


@pytest.mark.parametrize('heard', [record(4), record(2, 'task.failed')])
def test_heard_event_missing_in_journal_is_fault(heard: dict[str, Any]) -> None:
    (fault,) = vanished(JOURNAL, [JOURNAL[0], heard], 'A')
    assert f'1 events that are not in the journal, first {heard["seq"]}' in fault


def test_a_reader_that_is_told_all() -> None:
    assert list(misled([record(n) for n in (4, 5, 6)], 'A')) == []


def test_repeated_or_skipped_event_misleads_reader() -> None:
    assert list(misled([record(4), record(5), record(5)], 'A')) == [
        'A was told of event 5 after event 5'
    ]
    assert list(misled([record(4), record(7)], 'A')) == ['A was not told of the events 5 to 6']


def test_only_new_history_lets_reader_restart() -> None:
    first = [begun(1, 'x'), record(2), record(3)]
    assert list(misled([*first, begun(1, 'y'), record(2)], 'A')) == []
    assert len(list(misled([*first, begun(1, 'x'), record(2)], 'A'))) == 1
    assert len(list(misled([*first, record(1, 'orchestrator.started')], 'A'))) == 1


def test_good_copies() -> None:
    copies = [copy(0), copy(3), copy(5), {'kind': READ, 'refused': 'database is locked'}]
    assert list(bad_copies(ROWS, copies)) == []


@pytest.mark.parametrize(
    'bad',
    [
        copy(3, check='row 2 missing'),
        copy(3, digest=digest_of(ROWS[1:4])),
        copy(6, digest=digest_of([*ROWS, (6, '{}')])),
    ],
)
def test_damaged_or_foreign_copies_are_bad(bad: dict[str, Any]) -> None:
    assert len(list(bad_copies(ROWS, [copy(2), bad]))) == 1


def test_that_nothing_could_be_copied() -> None:
    refused = {'kind': BACKUP, 'refused': 'database is locked'}
    assert list(bad_copies(ROWS, [refused, {**copy(3), 'kind': READ}])) == [
        'of 1 copies none was made: database is locked'
    ]
