"""The sentences about a hold."""

from __future__ import annotations

from typing import Any

import pytest

from bt_orchestrator.model.hold_words import hold_name, hold_wait_words, hold_words, why_words
from bt_orchestrator.model.state import Hold


def hold(**fields: Any) -> Hold:
    plain: dict[str, Any] = {
        'id': '1',
        'job': 'J',
        'section': 2,
        'item': 'J/1',
        'task': 'work',
        'reason': 'aborted',
        'message': 'no grip',
        'answers': ('retry',),
        'since': 0.0,
    }
    return Hold(**{**plain, **fields})


OF_ITEM = hold(task=None, section=3, reason='overrun', message='')
OF_CELL = hold(job=None, section=None, item=None, task=None, reason='paused', message='Ann: tea')


@pytest.mark.parametrize(
    ('held', 'name', 'words'),
    [
        (hold(), 'hold 1 (work: aborted)', 'section 2, work of J/1: aborted (no grip)'),
        (OF_ITEM, 'hold 1 (J/1: overrun)', 'section 3, J/1: overrun'),
        (OF_CELL, 'hold 1 (paused, Ann: tea)', 'paused (Ann: tea)'),
    ],
)
def test_hold_has_short_name_and_full_text(held: Hold, name: str, words: str) -> None:
    assert hold_name(held) == name
    assert hold_words(held) == words
    assert hold_wait_words([held]) == f'waiting for an answer to {name}'


def test_several_holds_are_named_by_their_numbers() -> None:
    holds = [hold(id=number) for number in '346']
    assert hold_wait_words(holds) == 'waiting for answers to holds 3, 4 and 6'


def test_why() -> None:
    assert why_words('timeout', '') == 'timeout'
    assert why_words('aborted', 'no grip') == 'aborted (no grip)'


@pytest.mark.parametrize(
    ('message', 'words'),
    [
        ('no grip\nat (1, 2)', 'aborted (no grip at (1, 2))'),
        ('\x1b[2Jgone', 'aborted (\ufffd[2Jgone)'),
        (' \n', 'aborted'),
    ],
)
def test_controller_message_is_one_printable_line(message: str, words: str) -> None:
    assert why_words('aborted', message) == words
    assert hold_words(hold(message=message)).endswith(words)
    of_cell = hold(job=None, section=None, item=None, task=None, message=message)
    assert hold_name(of_cell).isprintable()
