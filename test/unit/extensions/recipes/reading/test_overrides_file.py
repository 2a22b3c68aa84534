"""Overrides: decisions about the script of one recipe."""

from __future__ import annotations

import pytest
from fakes.mistake_tables import table
from fakes.recipe_texts import overrides
from fakes.script_texts import mistakes

from bt_orchestrator.model.cell import OnFailure
from bt_orchestrator.model.recipe import Overrides


@pytest.mark.parametrize(('text', 'expected'), table('overrides'))
def test_mistakes(text: str, expected: list[str]) -> None:
    assert mistakes(lambda: overrides(text)) == expected


def test_overrides_are_read() -> None:
    read = overrides(
        'bind: {stick: press}\n'
        'set: {stick: {timeout: none, continue_if_fail: true}}\n'
        'order: [[place, stick], [stick, pack]]\n'
    )
    assert read == Overrides(
        {'stick': 'press'},
        {'stick': {'timeout_s': None, 'on_failure': OnFailure.CONTINUE}},
        (('place', 'stick'), ('stick', 'pack')),
    )
