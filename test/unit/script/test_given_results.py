"""Results that an operator gives are read against the action's type."""

from __future__ import annotations

import pytest

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.model.action_type import ActionType, FieldType, MessageType
from bt_orchestrator.script.given_values import given_results, results_of, results_text

POINT = MessageType('geometry_msgs/msg/Point', {'x': FieldType('float', 'double')})
ACTION = ActionType(
    'pkg/action/Look',
    MessageType('Goal', {}),
    MessageType(
        'pkg/action/Look_Result',
        {
            'task_result': FieldType('bool', 'boolean'),
            'measurement': FieldType('float', 'float32'),
            'count': FieldType('int', 'uint8', 0, 255),
            'label': FieldType('str', 'string'),
            'point': FieldType('message', 'geometry_msgs/Point', message=POINT),
            'values': FieldType('int', 'int32[]', -(2**31), 2**31 - 1, is_array=True),
        },
    ),
)


@pytest.mark.parametrize(
    ('words', 'results'),
    [
        (['measurement=3.5'], {'measurement': 3.5}),
        (['measurement=3', 'label=a, b: c'], {'measurement': 3.0, 'label': 'a, b: c'}),
        (['point.x=1'], {'point': {'x': 1.0}}),
        (['point={x: 2.5}', 'values=[1, -2]'], {'point': {'x': 2.5}, 'values': [1, -2]}),
        ([], {}),
    ],
)
def test_results_are_read_as_their_types(words: list[str], results: dict[str, object]) -> None:
    text = results_text(results_of(words))
    assert (given_results(text, ACTION) if text else {}) == results


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('{mesurement: 3.5}', 'has no field `mesurement`'),
        ('{measurement: high}', '`measurement` must be a number (float32), not the text `high`'),
        ('{count: 256}', '`count` must be a whole number from 0 to 255 (uint8)'),
        ('{task_result: true}', 'has no field `task_result`'),
        ('{point: {y: 1}}', 'has no field `point.y`'),
        ('{point: 1}', '`point` must be a mapping (geometry_msgs/Point)'),
        ('{values: [1, 2.5]}', '`values[1]` must be a whole number'),
        ('[1, 2]', 'results are a mapping, {field: value, ...}; found a list'),
        ('{measurement: .nan}', '`measurement` must be a finite number'),
        ('{a: [', 'results: '),
        ('x' * 100_000, 'the results have 100000 characters; expected at most 64000'),
    ],
)
def test_unfit_result_is_refused_with_explanation(text: str, message: str) -> None:
    with pytest.raises(CommandRefused) as refused:
        given_results(text, ACTION)
    assert message in str(refused.value)


@pytest.mark.parametrize('value', ['nan', '.nan', 'NaN', 'inf', '-.inf', 'Infinity', '1e999'])
def test_non_finite_number_is_refused_in_every_notation(value: str) -> None:
    """A shell, JSON and YAML write it in their own ways."""
    with pytest.raises(CommandRefused, match='`measurement` must be a finite number'):
        given_results(results_text(results_of([f'measurement={value}'])), ACTION)


@pytest.mark.parametrize(
    ('words', 'message'),
    [
        (['measurement'], 'a result is FIELD=VALUE'),
        (['=3'], 'a result is FIELD=VALUE'),
        (['point..x=3'], 'a result is FIELD=VALUE'),
        (['a=1', 'a=2'], 'a is given twice'),
        (['a=1', 'a.b=2'], 'a is given as a whole and in parts'),
    ],
)
def test_malformed_result_word_is_wrong_usage(words: list[str], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        results_of(words)


def test_an_odd_text_stays_text() -> None:
    assert results_of(['label=[a', 'note=x = y']) == {'label': '[a', 'note': 'x = y'}
