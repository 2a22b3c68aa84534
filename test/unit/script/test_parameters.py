"""Parameters that a script declares."""

from __future__ import annotations

import pytest
from fakes.mistake_tables import table
from fakes.script_texts import line, mistakes

from bt_orchestrator.model.script import Parameter


@pytest.mark.parametrize(('text', 'expected'), table('parameters'))
def test_parameters(text: str, expected: list[str]) -> None:
    assert mistakes(lambda: line(text)) == expected


def test_a_parameter_without_default_is_required() -> None:
    read = line(
        'params: {a: {type: str}, b: {type: float, default: 1}, c: {type: str, default: ""}}'
    )
    assert read.params == {
        'a': Parameter('a', 'str', None, required=True),
        'b': Parameter('b', 'float', 1.0, required=False),
        'c': Parameter('c', 'str', '', required=False),
    }
    assert isinstance(read.params['b'].default, float)
