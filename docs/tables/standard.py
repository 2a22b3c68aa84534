"""The 88 cells of test/data/isa95_methods.md: what the standard says of each method and state."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

PATH = Path(__file__).parents[2] / 'test' / 'data' / 'isa95_methods.md'

NONE = 'no such job order'
GONE = 'gone'


class Cell(NamedTuple):
    """What a method answers."""

    status: int
    after: str
    """The state that follows, `gone`, or nothing: as before."""


def read_table() -> Mapping[tuple[str, str], Cell]:
    """Return the cells by method and state."""
    rows = [_split(line) for line in PATH.read_text().splitlines() if line.startswith('|')]
    head, _rule, *methods = rows
    return {
        (row[0], state): _cell(text)
        for row in methods
        for state, text in zip(head[2:], row[2:], strict=True)
    }


def _split(line: str) -> list[str]:
    return [part.strip() for part in line.strip('|').split('|')]


def _cell(text: str) -> Cell:
    status, _, after = text.partition(' ')
    return Cell(int(status), after)
