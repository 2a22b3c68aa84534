"""Parallel groups and the release of the conveyor (semantics 3.1, 3.8)."""

from __future__ import annotations

import pytest
from fakes.mistake_tables import table
from fakes.script_texts import line, mistakes


@pytest.mark.parametrize(('text', 'expected'), table('section_rules'))
def test_rules_of_a_section(text: str, expected: list[str]) -> None:
    assert mistakes(lambda: line(text)) == expected
