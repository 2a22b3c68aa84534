"""The lists of files in CONTRIBUTING.md are complete: an example of each stands in these files."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest
from fakes.shipped import ROOT

TEXT = (ROOT / 'CONTRIBUTING.md').read_text(encoding='utf-8')
PACKAGE = ROOT / 'bt_orchestrator'
CODE = (*PACKAGE.rglob('*.py'), *(ROOT / 'interfaces').rglob('*.msg'))


class Example(NamedTuple):
    """What was added once."""

    code: str
    """What its code is found by."""
    words: str
    """What tests and pages call it."""


EXAMPLES = {
    'a request': Example('REMOVE_ITEM', 'remove[_-]item'),
    'a fact': Example('contested_words', 'contested_words'),
    'a script key': Example('retry_delay_s', 'retry_delay'),
    'an export': Example('CsvExport', 'csv'),
}


class Row(NamedTuple):
    """One row of a list."""

    places: tuple[Path, ...]
    is_needed: bool


def rows(what: str) -> Iterator[Row]:
    """Yield the rows of a list; files of the package stand there without its name."""
    _, _, section = TEXT.partition(f'## Add {what}\n')
    for first, second in re.findall(
        r'^\| (.+?) \| (.+) \|$', section.partition('\n## ')[0], re.MULTILINE
    ):
        names = re.findall(r'`([\w./]+)`', first)
        if names:
            places = (ROOT / name if (ROOT / name).exists() else PACKAGE / name for name in names)
            yield Row(tuple(places), not second.startswith('only if'))


def holds(place: Path, file: Path) -> bool:
    return file == place or place in file.parents


def naming(place: Path, words: str) -> list[Path]:
    """Return the files of a place that name an example."""
    files = [place] if place.is_file() else place.rglob('*')
    texts = (file for file in files if file.suffix in {'.py', '.md', '.msg', '.txt'})
    return [file for file in texts if re.search(words, file.read_text(encoding='utf-8'))]


def test_every_list_has_an_example() -> None:
    assert re.findall('^## Add (.+)$', TEXT, re.MULTILINE) == list(EXAMPLES)


@pytest.mark.parametrize('what', EXAMPLES)
def test_example_code_appears_only_in_listed_files(what: str) -> None:
    places = [place for row in rows(what) for place in row.places]
    matches = [file for file in CODE if re.search(rf'\b{EXAMPLES[what].code}\b', file.read_text())]
    assert matches
    missing = [file for file in matches if not any(holds(place, file) for place in places)]
    assert missing == [], 'not in the list'


@pytest.mark.parametrize('what', EXAMPLES)
def test_every_file_of_a_list_names_its_example(what: str) -> None:
    words = f'{EXAMPLES[what].words}|{EXAMPLES[what].code}'
    needed = [place for row in rows(what) if row.is_needed for place in row.places]
    assert len(needed) > 3
    assert [str(place) for place in needed if not naming(place, words)] == []
