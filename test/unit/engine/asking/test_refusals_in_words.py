"""A refusal is a fact: its sentences stand in the catalogue, so that each language has them.

The fakes check each refusal of all tests (`fakes/refusals.py`); here are those that are on record.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from fakes.refusals import check_refusal

ROOT = Path(__file__).parents[4]
RECORDS = sorted((ROOT / 'test' / 'data' / 'requests').glob('*.txt'))
PACKAGE = ROOT / 'bt_orchestrator'
ROOMS = (
    *(f'{room}/**/*.py' for room in ('engine', 'model', 'script/orders')),
    'script/given_values.py',
    'script/users/keys.py',
)
"""Where requests are refused."""

ERRORS = ('CommandRefused', 'BadArguments', 'NotRead')

WITHOUT_HISTORY = ('a stop has a name as in :', 'another history than this journal, which is ')
"""The bench of these records has no history."""


def bare_texts(module: str) -> Iterator[int]:
    """Yield the lines in which an error of a request is raised with a text that is no fact."""
    for node in ast.walk(ast.parse(module)):
        match node:
            case ast.Call(ast.Name(name), [first, *_]) if name in ERRORS:
                if any(_texts(first)):
                    yield node.lineno


def _texts(node: ast.expr) -> Iterator[ast.expr]:
    """Yield texts in an expression, without those that a function is called with."""
    match node:
        case ast.JoinedStr() | ast.Constant(str()):
            yield node
        case ast.BinOp(left, _, right):
            yield from (*_texts(left), *_texts(right))
        case ast.IfExp(_, body, other):
            yield from (*_texts(body), *_texts(other))
        case ast.Call(ast.Attribute(value, 'join' | 'format')):
            yield from _texts(value)


def test_no_request_is_refused_with_a_bare_text() -> None:
    files = [file for room in ROOMS for file in sorted(PACKAGE.glob(room))]
    assert len(files) > 100
    found = [
        f'{file.relative_to(ROOT)}:{line}'
        for file in files
        for line in bare_texts(file.read_text(encoding='utf-8'))
    ]
    assert found == [], 'make it a sentence of model/words'


@pytest.mark.parametrize(
    ('argument', 'is_bare'),
    [
        ("'no'", True),
        ("f'no {x}'", True),
        ("'no ' + x", True),
        ("x if y else 'no'", True),
        ("'; '.join(x)", True),
        ("sentence('no', x=f'{y}')", False),
        ("joined(sentence('no'), x)", False),
        ('str(why)', False),
        ('why_not, each', False),
    ],
)
def test_a_bare_text_is_found(argument: str, is_bare: bool) -> None:
    assert list(bare_texts(f'raise CommandRefused({argument})')) == [1] * is_bare


@pytest.mark.parametrize('file', RECORDS, ids=lambda file: file.stem)
def test_each_refusal_on_record_can_be_read(file: Path) -> None:
    refused = re.findall(r'^> .*?: refused: (.*)$', file.read_text(encoding='utf-8'), re.MULTILINE)
    for message in refused:
        if not any(words in message for words in WITHOUT_HISTORY):
            check_refusal(message)


@pytest.mark.parametrize(
    'message',
    [
        'the robot is tired',
        'nothing was done; the robot is tired',
        'a1 gets no goal: the robot is tired',
    ],
)
def test_a_refusal_in_other_words_is_seen(message: str) -> None:
    with pytest.raises(AssertionError):
        check_refusal(message)
