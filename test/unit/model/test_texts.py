"""Texts of people for the record."""

from __future__ import annotations

import pytest

from bt_orchestrator.model.texts import readable, text_fault

BIDI = ['\u202a', '\u202e', '\u2066', '\u2069', '\u200e', '\u200f', '\u061c']
OTHERS = ['\x00', '\x1b', '\x7f', '\x9b', '\u200b', '\ufeff', '\ud800', '\u2028']


@pytest.mark.parametrize('char', [*BIDI, *OTHERS])
def test_invisible_or_direction_changing_characters_are_named(char: str) -> None:
    fault = text_fault(f'by hand {char}')
    assert fault is not None
    assert f'U+{ord(char):04X}' in fault
    assert readable(f'a{char}b') == 'a\ufffdb'


@pytest.mark.parametrize(
    'text', ['', 'Motor läuft heiß', 'two\nlines\tand a tab', 'می‌خواهم', '👷‍♀️ 機械', 'a\xa0b']
)
def test_what_people_write_is_taken(text: str) -> None:
    assert text_fault(text) is None
    assert readable(text) == text
