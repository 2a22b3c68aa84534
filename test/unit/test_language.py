"""How the product speaks: plain words, short sentences (test/data/language.yaml)."""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import Any, NamedTuple

import prose
import pytest
import yaml
from fakes.shipped import ROOT

LIST = yaml.safe_load((ROOT / 'test' / 'data' / 'language.yaml').read_text(encoding='utf-8'))
MOST_WORDS: int = LIST['most_words']


class Construction(NamedTuple):
    """What is not written, and what is written instead."""

    name: str
    pattern: re.Pattern[str]
    better: str
    caught: str
    fine: str

    @classmethod
    def of(cls, row: dict[str, Any]) -> Construction:
        """Return one of the list."""
        flags = 0 if row.get('case') else re.IGNORECASE
        pattern = re.compile(row['pattern'], flags)
        return cls(row['name'], pattern, row['better'], row['caught'], row['fine'])


CONSTRUCTIONS = [Construction.of(row) for row in LIST['constructions']]


def banned_in(texts: Iterable[str]) -> Iterator[str]:
    """Yield a complaint for each construction in sentences that is banned."""
    for text in texts:
        for sentence in prose.sentences(text):
            for construction in CONSTRUCTIONS:
                if construction.pattern.search(sentence):
                    yield f'{construction.name}: "{sentence}"; better: {construction.better}'


def long_in(texts: Iterable[str]) -> Iterator[str]:
    """Yield a complaint for each sentence that is too long."""
    for text in texts:
        for sentence in prose.sentences(text):
            if (words := len(sentence.split())) > MOST_WORDS:
                yield f'{words} words, {MOST_WORDS} at most: "{sentence}"'


Complaints = dict[str, list[str]]
"""By page, verb or file."""

Complain = Callable[[Iterable[str]], Iterator[str]]


def of_pages(complain: Complain) -> Complaints:
    return {
        page: [*complain(prose.sentences_of_page(text))] for page, text in prose.pages().items()
    }


def of_help(complain: Complain) -> Complaints:
    return {verb: [*complain(texts)] for verb, texts in prose.help_texts().items()}


def of_code(texts: Callable[[ast.Module], Iterator[str]]) -> Complaints:
    complaints: Complaints = {}
    for path, module in prose.modules().items():
        lines = complaints.setdefault(prose.package_file(path), [])
        lines += [f'{path}: {it}' for it in banned_in(texts(module))]
    return complaints


def of_messages() -> Complaints:
    return {**of_code(prose.messages), 'en.json': [*banned_in(prose.words_of_the_page())]}


def of_names() -> Complaints:
    """Of the package, of its tests, and of the bench."""
    everywhere = {**prose.modules(), **prose.modules('test'), **prose.modules('bench')}
    return {
        path: [name for name in prose.variables(module) if name in LIST['names']]
        for path, module in everywhere.items()
        if not path.startswith('test/data/')  # of a release
    }


def of_test_names() -> Complaints:
    most = LIST['most_words_of_a_test']
    return {
        path: [*prose.long_test_names(module, most)]
        for path, module in prose.modules('test').items()
    }


KINDS: dict[str, Callable[[], Complaints]] = {
    'words of pages': partial(of_pages, banned_in),
    'sentences of pages': partial(of_pages, long_in),
    'words of messages': of_messages,
    'words of docstrings': partial(of_code, prose.first_lines),
    'names in code': of_names,
    'names of tests': of_test_names,
    'words of help': partial(of_help, banned_in),
    'sentences of help': partial(of_help, long_in),
}


@pytest.mark.parametrize('kind', KINDS)
def test_the_language_is_plain(kind: str) -> None:
    wrong = {name: lines for name, lines in KINDS[kind]().items() if lines}
    assert wrong == {}, '\n'.join(
        f'{name}:\n  ' + '\n  '.join(lines) for name, lines in wrong.items()
    )


@pytest.mark.parametrize('construction', CONSTRUCTIONS, ids=lambda construction: construction.name)
def test_banned_constructions_are_caught_and_good_sentences_pass(
    construction: Construction,
) -> None:
    assert [it.partition(':')[0] for it in banned_in([construction.caught])] == [construction.name]
    assert list(banned_in([construction.fine])) == []


def test_a_long_sentence_is_caught() -> None:
    words = ' '.join(['Words', *['follow'] * (MOST_WORDS - 1)])
    assert list(long_in([f'{words}. {words}.'])) == []
    assert len(list(long_in([f'{words} more.']))) == 1


def test_names_are_those_of_variables_and_parameters() -> None:
    code = (
        'class Check:\n    said: str\n    def of(self, one):\n        found = [it for it in one]'
    )
    assert sorted(prose.variables(ast.parse(code))) == ['found', 'it', 'one', 'self']


def test_words_of_a_test_name_are_counted() -> None:
    code = 'def test_3_1_a_b_c(): ...\ndef test_a_b(): ...\ndef of_a_b_c_d(): ...'
    assert [*prose.long_test_names(ast.parse(code), 2)] == ['test_3_1_a_b_c']


def test_sentences_of_a_page_are_its_readable_text() -> None:
    page = (
        '# What a title says\n\nFirst one, with `code of it` and\n[a link](x.md). Second one.\n\n'
        '- item\n- other (in brackets). Third.\n\n```sh\nnobody\n```\n\n| a | b |\n|---|---|\n'
        '| c d; f | e |\n<!-- generated: x -->\nnobody\n<!-- end -->\n'
    )
    sentences = [sentence for sentence in prose.sentences_of_page(page) if '-' not in sentence]
    assert sentences == [
        'First one, with `…` and a link.',
        'Second one.',
        'item',
        'other (in brackets).',
        'Third.',
        *('a', 'b', 'c d', 'f', 'e'),
    ]


def test_every_kind_of_text_is_read() -> None:
    assert len(prose.pages()) > 20
    assert Counter(bool(lines) for lines in prose.help_texts().values())[True] > 25
    module = prose.modules()['bt_orchestrator/cli/verbs.py']
    assert 'The verbs of the program, and what a command line of theirs means.' in set(
        prose.first_lines(module)
    )
    assert 'set up a cell and its products' in set(prose.messages(module))
    assert len(list(prose.words_of_the_page())) > 500
