"""The schemas for editors: they take what the reader takes, and know every structural mistake."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, cast

import pytest
from fakes.mistake_tables import FOLDER, table
from fakes.mistake_texts import AROUND
from fakes.schemas import refusals

if TYPE_CHECKING:
    from _pytest.mark.structures import ParameterSet

STRUCTURAL = re.compile(
    r'.* (has no key|needs the key `(?!task`)|has no value;|cannot be `\w*`; write one of'
    r'|needs one of|needs two bounds|has no (conditions|values)|has one comparison|stands beside'
    r'|this repeat has no tasks'
    r'|must be (a mapping|a list|a number|one of|at least|at most|greater|true or false'
    r'|a date|a (whole|section) number))'
    r'|.*`\w+` is empty'
)
"""Findings that one file alone is enough for."""

BEYOND = re.compile(
    r'.*\([\w/]+(\[[\w<=]*\])?\)|.*, not the number \d+\.0;|.*; refer to a value of that type'
)
"""Findings that a ROS 2 type or a parameter is needed for: they name it. And 2.0, where 2 is
needed: to a schema they are the same."""


def is_structural(finding: str) -> bool:
    return bool(STRUCTURAL.match(finding)) and not BEYOND.match(finding)


def cases(wanted: Callable[[Sequence[str]], bool]) -> Iterator[ParameterSet]:
    """Yield the texts of all tables whose findings are the ones wanted."""
    for name, around in AROUND.items():
        for case in table(name):
            text, findings = cast(tuple[str, list[str]], case.values)
            if wanted(findings):
                yield pytest.param(around.file, around.whole(text), id=f'{name}: {case.id}')


def is_told_of_structure(findings: Sequence[str]) -> bool:
    return any(map(is_structural, findings))


def test_every_mistake_table_matches_a_file_kind() -> None:
    elsewhere = {'yaml', 'orders_by_recipe'}  # the second: mistakes that only a recipe shows
    assert {path.stem for path in FOLDER.glob('*.txt')} == {*AROUND, *elsewhere}


@pytest.mark.parametrize(('file', 'text'), list(cases(operator.not_)))
def test_what_the_reader_takes_the_schema_takes(file: str, text: str) -> None:
    assert refusals(file, text) == []


@pytest.mark.parametrize(('file', 'text'), list(cases(is_told_of_structure)))
def test_a_structural_mistake_is_refused(file: str, text: str) -> None:
    assert refusals(file, text)
