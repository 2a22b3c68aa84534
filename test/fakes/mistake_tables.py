"""Tables of mistakes (test/data/mistakes): a text that a user may write, and what it is told.

    === what is tried
    the text, one or more lines
    > line:column: what; hint

A text without `>` lines is right.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from _pytest.mark.structures import ParameterSet

FOLDER = Path(__file__).parents[1] / 'data' / 'mistakes'


def table(name: str) -> list[ParameterSet]:
    """Return the cases of a table as pairs of a text and the findings expected."""
    sections = (FOLDER / f'{name}.txt').read_text(encoding='utf-8').split('=== ')[1:]
    assert sections, f'{name} has no cases'
    return [_case(*section.partition('\n')[::2]) for section in sections]


def _case(name: str, lines: str) -> ParameterSet:
    text = [line for line in lines.splitlines() if not line.startswith('> ')]
    expected = [line[2:] for line in lines.splitlines() if line.startswith('> ')]
    return pytest.param('\n'.join(text), expected, id=name)
