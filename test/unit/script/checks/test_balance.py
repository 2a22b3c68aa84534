"""Every item is placed once and taken out once (semantics 3.2)."""

from __future__ import annotations

import pytest
from fakes.mistake_tables import table
from fakes.script_texts import mistakes, script


@pytest.mark.parametrize(('text', 'expected'), table('balance'))
def test_balance(text: str, expected: list[str]) -> None:
    assert mistakes(lambda: script(text)) == expected
