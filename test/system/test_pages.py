"""Somebody who follows README and guide from the first line to the last gets what they show."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from cell_processes import ROOT
from page_reader import PageReader, Typed, typed

FIRST_PAGES = ('README.md', 'docs/guide.md')
LINE = 'docs/line.md'
PAGES = (*FIRST_PAGES, 'docs/recipes.md', LINE)
FIRST_HOUR = [
    'new-cell',
    'check',
    'render',
    'simulate',
    'sim-cell',
    'run',
    'submit',
    'status',
    'answer',
]


@pytest.fixture
def reader(tmp_path: Path) -> Iterator[PageReader]:
    reader = PageReader(tmp_path)
    yield reader
    reader.close()


@pytest.mark.parametrize('page', PAGES)
@pytest.mark.long
def test_a_page_can_be_followed(page: str, reader: PageReader) -> None:
    for step in typed(ROOT / page):
        reader.follow(step)
    reader.leave()
    if page == LINE:
        assert (reader.here / 'pump.svg').read_text() == (ROOT / 'docs' / 'line.svg').read_text()


def test_pages_show_verbs_of_first_hour() -> None:
    shown = {step.verb for page in FIRST_PAGES for step in typed(ROOT / page)}
    assert shown - {''} == {*FIRST_HOUR}


def test_page_with_wrong_output_is_detected(reader: PageReader) -> None:
    reader.follow(Typed('', 'echo 3 items, 13.0 s', '3 items, …\n', is_after_interrupt=False))
    with pytest.raises(AssertionError, match='3 items'):
        reader.follow(Typed('', 'echo 3 items', '4 items\n', is_after_interrupt=False))
    with pytest.raises(AssertionError, match='wrong'):
        reader.follow(Typed('', 'echo wrong; false', '', is_after_interrupt=False))
