"""Each page is of one kind, and the index leads every reader to it by at most 15,000 words."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

import prose
import pytest
from fakes.shipped import ROOT

DOCS = ROOT / 'docs'
INDEX = (DOCS / 'README.md').read_text(encoding='utf-8')
KINDS = ('tutorial', 'how-to', 'reference', 'explanation')
MOST_WORDS = 15_000
EVERYBODY = 'everybody'


def rows(heading: str) -> list[list[str]]:
    """Return the rows of the table below a heading of the index."""
    part = INDEX.partition(f'## {heading}\n')[2].partition('\n## ')[0]
    lines = [line for line in part.splitlines() if line.startswith('| ')][1:]
    return [[cell.strip() for cell in line.strip('|').split(' | ')] for line in lines]


def linked(text: str) -> list[Path]:
    return [(DOCS / target).resolve() for target in re.findall(r'\]\(([^)#]+)\)', text)]


def kinds_in_index() -> dict[Path, str]:
    return {page: kind for _, pages, kind in rows('By question') for page in linked(pages)}


PAGES = [path for path in sorted(DOCS.glob('*.md')) if path.name != 'README.md']


@pytest.mark.parametrize('path', PAGES, ids=lambda path: path.name)
def test_page_has_one_kind_matching_the_index(path: Path) -> None:
    kind = re.match(r'# .*\n\n\*([\w-]+)(?:, for [^*]*)?\.\*', path.read_text(encoding='utf-8'))
    assert kind, 'the line below the title says its kind'
    assert kind[1].lower() in KINDS
    assert kinds_in_index()[path] == kind[1].lower()


def words_by_reader() -> dict[str, int]:
    """Return how many words each reader is led through, without generated tables."""
    read = {reader: linked(pages) for reader, pages in rows('By reader')}
    return {
        reader: sum(map(words_of, {*read[EVERYBODY], *pages})) for reader, pages in read.items()
    }


def words_of(path: Path) -> int:
    return len(prose.without_generated(path.read_text(encoding='utf-8')).split())


def test_no_reader_gets_more_words_than_promised() -> None:
    words = words_by_reader()
    assert f'{MOST_WORDS:,} words' in INDEX
    assert {reader: n for reader, n in words.items() if n > MOST_WORDS} == {}
    assert min(words.values()) > 2_000


def test_every_learning_or_doing_page_has_a_reader() -> None:
    read = {page for _, pages in rows('By reader') for page in linked(pages)}
    lost = {page.name for page, kind in kinds_in_index().items() if kind in KINDS[:2]} - {
        page.name for page in read
    }
    assert lost == set()


def test_a_word_has_one_meaning_in_the_glossary() -> None:
    text = (DOCS / 'glossary.md').read_text(encoding='utf-8')
    words = [
        word.strip()
        for cell in re.findall(r'^\| ([^|]+) \| [^|]+ \|$', text, re.MULTILINE)
        if cell not in ('word', '---')
        for word in cell.split(',')
    ]
    assert len(words) > 50
    assert [word for word, n in Counter(words).items() if n > 1] == []
