from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import pytest
from fakes.statuses import status

from bt_orchestrator.extensions.page.web.book import Book, Cursor
from bt_orchestrator.model.by import Known
from bt_orchestrator.model.codec import to_record
from bt_orchestrator.model.events import JobHeld, OperatorDecided
from bt_orchestrator.ports.doors.following_door import Happened, Lost


def book_with(*seqs: int, before: int = 0) -> Book:
    book = Book()
    book.begin('one', before)
    for seq in seqs:
        book.ring.add(Happened(JobHeld(seq=seq, job='J')))
    return book


def read(text: bytes | None) -> dict[str, Any]:
    """Return the object in a message."""
    assert text is not None
    (data,) = (line for line in text.decode().splitlines() if line.startswith('data: '))
    found: dict[str, Any] = json.loads(data.removeprefix('data: '))
    return found


class TestParts:
    def test_a_new_reader_gets_all(self) -> None:
        book = book_with()
        book.put({'cell': {'state': 'Idle'}, 'job/1': {}})
        found = read(book.next_parts(Cursor('one', 0)))
        assert found == {'version': 1, 'set': {'cell': {'state': 'Idle'}, 'job/1': {}}, 'gone': []}

    def test_only_what_changed_comes_again(self) -> None:
        book, cursor = book_with(), Cursor('one', 0)
        book.put({'cell': {'state': 'Idle'}, 'job/1': {'n': 1}})
        book.next_parts(cursor)
        book.put({'cell': {'state': 'Idle'}, 'job/1': {'n': 2}})
        assert read(book.next_parts(cursor))['set'] == {'job/1': {'n': 2}}
        assert book.next_parts(cursor) is None

    def test_the_same_parts_are_no_news(self) -> None:
        book, cursor = book_with(), Cursor('one', 0)
        book.put({'cell': {'state': 'Idle'}})
        book.next_parts(cursor)
        book.put({'cell': {'state': 'Idle'}})
        assert book.next_parts(cursor) is None

    def test_what_went_is_told_to_those_who_had_it(self) -> None:
        book, cursor = book_with(), Cursor('one', 0)
        book.put({'hold/1': {}, 'cell': {}})
        book.next_parts(cursor)
        book.put({'cell': {}})
        assert read(book.next_parts(cursor))['gone'] == ['hold/1']
        assert read(book.next_parts(Cursor('one', 0)))['gone'] == []

    def test_what_came_back_is_not_gone(self) -> None:
        book, cursor = book_with(), Cursor('one', 0)
        book.put({'hold/1': {}})
        book.next_parts(cursor)
        book.put({})
        book.put({'hold/1': {}})
        assert read(book.next_parts(cursor)) == {
            'version': 3,
            'set': {'hold/1': {}},
            'gone': [],
        }

    def test_a_reader_that_missed_a_version_still_hears_what_went(self) -> None:
        book, cursor = book_with(), Cursor('one', 0)
        book.put({'hold/1': {}, 'cell': {}})
        book.next_parts(cursor)
        book.put({'cell': {}})
        book.forget_gone(cursor.version)
        book.put({'cell': {'n': 1}})
        found = read(book.next_parts(cursor))
        assert (found['set'], found['gone']) == ({'cell': {'n': 1}}, ['hold/1'])

    def test_it_is_encoded_once_for_all_readers(self) -> None:
        book = book_with()
        book.put({'cell': {}})
        first, second = Cursor('one', 0), Cursor('one', 0)
        assert book.next_parts(first) is book.next_parts(second)

    def test_parts_of_another_history_are_void(self) -> None:
        book = book_with()
        book.put({'hold/1': {}})
        book.begin('two', 0)
        assert book.next_parts(Cursor('two', 0)) is None
        book.put({'cell': {}})
        assert read(book.next_parts(Cursor('two', 0)))['set'] == {'cell': {}}


class TestEvents:
    def test_a_reader_gets_each_event_once(self) -> None:
        book, cursor = book_with(1, 2, 3), Cursor('one', 1)
        text = book.next_events(cursor)
        assert [record['seq'] for record in read(text)['records']] == [2, 3]
        assert b'id: one:3\n' in (text or b'')
        assert book.next_events(cursor) is None
        assert cursor.seq == 3

    def test_they_are_encoded_once_for_all_readers(self) -> None:
        book = book_with(1, 2)
        first, second = Cursor('one', 0), Cursor('one', 0)
        assert book.next_events(first) is book.next_events(second)
        assert first == second

    def test_numbers_of_another_history_are_other_events(self) -> None:
        book = book_with(1, 2)
        book.next_events(Cursor('one', 0))
        book.begin('two', 0)
        book.ring.add(Happened(JobHeld(seq=1, job='K')))
        book.ring.add(Happened(JobHeld(seq=2, job='K')))
        found = read(book.next_events(Cursor('two', 0)))
        assert found['history'] == 'two'
        assert {record['job'] for record in found['records']} == {'K'}

    def test_a_loss_is_told_and_passed(self) -> None:
        book, cursor = book_with(1), Cursor('one', 1)
        book.ring.add(Lost(2, 4))
        assert read(book.next_events(cursor)) == {'first': 2, 'last': 4}
        assert cursor.seq == 4


class TestStart:
    def test_a_new_reader_begins_with_what_the_parts_tell_of(self) -> None:
        book = book_with(8, before=7)
        book.status = replace(status(), seq=9, history='one')
        assert book.start('', None) == Cursor('one', 9)

    def test_who_comes_back_goes_on(self) -> None:
        assert book_with(8, before=7).start('one', 3) == Cursor('one', 3)

    def test_who_comes_back_with_another_history_begins_anew(self) -> None:
        assert book_with(8, before=7).start('zero', 3) == Cursor('one', 8)

    def test_who_was_away_for_long_is_behind(self) -> None:
        book = book_with(8, before=7)
        assert book.is_behind(Cursor('one', 6))
        assert not book.is_behind(Cursor('one', 7))


@pytest.mark.parametrize(
    ('who', 'known', 'named'),
    [
        ('ann', Known.PAGE_LOGIN, 'ann'),
        ('ann', Known.ROS, 'somebody who claims to be ann'),
        ('', Known.ROS, None),
    ],
)
def test_a_decision_comes_with_its_name_as_it_is_shown(
    who: str, known: Known, named: str | None
) -> None:
    book, cursor = book_with(), Cursor('one', 0)
    decided = OperatorDecided(seq=1, who=who, reason='r', known=known.value, answer='retry')
    book.ring.add(Happened(decided))
    message = read(book.next_events(cursor))
    assert message['records'] == [to_record(decided)]
    assert message.get('names', {}).get('1') == named
