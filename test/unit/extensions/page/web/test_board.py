from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import pytest
from fakes.statuses import status

from bt_orchestrator.extensions.page.web.board import Board, Cursor
from bt_orchestrator.model.by import Known
from bt_orchestrator.model.codec import to_record
from bt_orchestrator.model.events import JobHeld, OperatorDecided
from bt_orchestrator.ports.doors.following_door import Happened, Lost


def board_with(*seqs: int, before: int = 0) -> Board:
    board = Board()
    board.begin('one', before)
    for seq in seqs:
        board.ring.add(Happened(JobHeld(seq=seq, job='J')))
    return board


def read(text: bytes | None) -> dict[str, Any]:
    """Return the object in a message."""
    assert text is not None
    (data,) = (line for line in text.decode().splitlines() if line.startswith('data: '))
    message: dict[str, Any] = json.loads(data.removeprefix('data: '))
    return message


class TestParts:
    def test_a_new_reader_gets_all(self) -> None:
        board = board_with()
        board.put({'cell': {'state': 'Idle'}, 'job/1': {}})
        parts = read(board.next_parts(Cursor('one', 0)))
        assert parts == {'version': 1, 'set': {'cell': {'state': 'Idle'}, 'job/1': {}}, 'gone': []}

    def test_only_what_changed_comes_again(self) -> None:
        board, cursor = board_with(), Cursor('one', 0)
        board.put({'cell': {'state': 'Idle'}, 'job/1': {'n': 1}})
        board.next_parts(cursor)
        board.put({'cell': {'state': 'Idle'}, 'job/1': {'n': 2}})
        assert read(board.next_parts(cursor))['set'] == {'job/1': {'n': 2}}
        assert board.next_parts(cursor) is None

    def test_the_same_parts_are_no_news(self) -> None:
        board, cursor = board_with(), Cursor('one', 0)
        board.put({'cell': {'state': 'Idle'}})
        board.next_parts(cursor)
        board.put({'cell': {'state': 'Idle'}})
        assert board.next_parts(cursor) is None

    def test_gone_parts_are_sent_to_their_readers(self) -> None:
        board, cursor = board_with(), Cursor('one', 0)
        board.put({'hold/1': {}, 'cell': {}})
        board.next_parts(cursor)
        board.put({'cell': {}})
        assert read(board.next_parts(cursor))['gone'] == ['hold/1']
        assert read(board.next_parts(Cursor('one', 0)))['gone'] == []

    def test_what_came_back_is_not_gone(self) -> None:
        board, cursor = board_with(), Cursor('one', 0)
        board.put({'hold/1': {}})
        board.next_parts(cursor)
        board.put({})
        board.put({'hold/1': {}})
        assert read(board.next_parts(cursor)) == {
            'version': 3,
            'set': {'hold/1': {}},
            'gone': [],
        }

    def test_late_reader_still_hears_gone_parts(self) -> None:
        board, cursor = board_with(), Cursor('one', 0)
        board.put({'hold/1': {}, 'cell': {}})
        board.next_parts(cursor)
        board.put({'cell': {}})
        board.forget_gone(cursor.version)
        board.put({'cell': {'n': 1}})
        parts = read(board.next_parts(cursor))
        assert (parts['set'], parts['gone']) == ({'cell': {'n': 1}}, ['hold/1'])

    def test_it_is_encoded_once_for_all_readers(self) -> None:
        board = board_with()
        board.put({'cell': {}})
        first, second = Cursor('one', 0), Cursor('one', 0)
        assert board.next_parts(first) is board.next_parts(second)

    def test_parts_of_another_history_are_void(self) -> None:
        board = board_with()
        board.put({'hold/1': {}})
        board.begin('two', 0)
        assert board.next_parts(Cursor('two', 0)) is None
        board.put({'cell': {}})
        assert read(board.next_parts(Cursor('two', 0)))['set'] == {'cell': {}}


class TestEvents:
    def test_a_reader_gets_each_event_once(self) -> None:
        board, cursor = board_with(1, 2, 3), Cursor('one', 1)
        text = board.next_events(cursor)
        assert [record['seq'] for record in read(text)['records']] == [2, 3]
        assert b'id: one:3\n' in (text or b'')
        assert board.next_events(cursor) is None
        assert cursor.seq == 3

    def test_they_are_encoded_once_for_all_readers(self) -> None:
        board = board_with(1, 2)
        first, second = Cursor('one', 0), Cursor('one', 0)
        assert board.next_events(first) is board.next_events(second)
        assert first == second

    def test_numbers_of_another_history_are_other_events(self) -> None:
        board = board_with(1, 2)
        board.next_events(Cursor('one', 0))
        board.begin('two', 0)
        board.ring.add(Happened(JobHeld(seq=1, job='K')))
        board.ring.add(Happened(JobHeld(seq=2, job='K')))
        message = read(board.next_events(Cursor('two', 0)))
        assert message['history'] == 'two'
        assert {record['job'] for record in message['records']} == {'K'}

    def test_a_loss_is_told_and_passed(self) -> None:
        board, cursor = board_with(1), Cursor('one', 1)
        board.ring.add(Lost(2, 4))
        assert read(board.next_events(cursor)) == {'first': 2, 'last': 4}
        assert cursor.seq == 4


class TestStart:
    def test_new_reader_starts_where_parts_end(self) -> None:
        board = board_with(8, before=7)
        board.status = replace(status(), seq=9, history='one')
        assert board.start('', None) == Cursor('one', 9)

    def test_who_comes_back_goes_on(self) -> None:
        assert board_with(8, before=7).start('one', 3) == Cursor('one', 3)

    def test_who_comes_back_with_another_history_begins_anew(self) -> None:
        assert board_with(8, before=7).start('zero', 3) == Cursor('one', 8)

    def test_who_was_away_for_long_is_behind(self) -> None:
        board = board_with(8, before=7)
        assert board.is_behind(Cursor('one', 6))
        assert not board.is_behind(Cursor('one', 7))


@pytest.mark.parametrize(
    ('who', 'known', 'named'),
    [
        ('ann', Known.PAGE_LOGIN, 'ann'),
        ('ann', Known.ROS, 'somebody who claims to be ann'),
        ('', Known.ROS, None),
    ],
)
def test_decision_carries_its_displayed_name(who: str, known: Known, named: str | None) -> None:
    board, cursor = board_with(), Cursor('one', 0)
    decided = OperatorDecided(seq=1, who=who, reason='r', known=known.value, answer='retry')
    board.ring.add(Happened(decided))
    message = read(board.next_events(cursor))
    assert message['records'] == [to_record(decided)]
    assert message.get('names', {}).get('1') == named
