"""What a controller says in its result, as it is kept with a failure."""

from __future__ import annotations

from typing import Any

import pytest

from bt_orchestrator.model.action_type import FieldType, MessageType
from bt_orchestrator.model.goal import controller_words, words_field

STRING = FieldType('str', 'string')


@pytest.mark.parametrize(
    ('result', 'message'),
    [
        ({}, ''),
        ({'task_result': False, 'measurement': 2.5}, ''),
        ({'message': ' no vacuum at gripper 2\n'}, 'no vacuum at gripper 2'),
        ({'message': 'no vacuum', 'code': 'E42'}, 'no vacuum'),
        ({'message': ' ', 'code': 'E42', 'note': ''}, 'code: E42'),
        (
            {'code': 'E42', 'status': {'text': 'door open', 'n': 3}},
            'code: E42; status.text: door open',
        ),
        ({'lines': ['a', '', 'b'], 'many': [1.0] * 1000}, 'lines[0]: a; lines[2]: b'),
        ({'message': 7, 'text': 'seven'}, 'text: seven'),
    ],
)
def test_message_else_every_text(result: dict[str, Any], message: str) -> None:
    assert controller_words(result) == message


@pytest.mark.parametrize('result', [{'message': 'x' * 900}, {'a': 'x' * 300, 'b': 'y' * 300}])
def test_long_words_are_cut_with_a_mark(result: dict[str, Any]) -> None:
    text = controller_words(result)
    assert len(text) == 500
    assert text.endswith('characters, the rest is cut)')


def test_simulated_controllers_use_message_or_first_text() -> None:
    flag = FieldType('bool', 'boolean')
    assert words_field(MessageType('R', {'code': STRING, 'message': STRING})) == 'message'
    assert words_field(MessageType('R', {'ok': flag, 'code': STRING, 'note': STRING})) == 'code'
    assert words_field(MessageType('R', {'ok': flag})) == ''
