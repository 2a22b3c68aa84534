"""An answer is a fact: its sentences stand in the catalogue, so that each language has them.

The fakes check each answer of all tests (`fakes/answers.py`); here are those that are on record.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from fakes.answers import check_answer

ROOT = Path(__file__).parents[4]
RECORDS = sorted((ROOT / 'test' / 'data' / 'requests').glob('*.txt'))
PACKAGE = ROOT / 'bt_orchestrator'
ROOMS = (
    *(f'{room}/**/*.py' for room in ('engine', 'model', 'script/orders')),
    'script/given_values.py',
    'script/users/keys.py',
)
"""Where requests are answered."""

ERRORS = ('CommandRefused', 'BadArguments', 'NotRead')

WITHOUT_HISTORY = ('a stop has a name as in :', 'another history than this journal, which is ')
"""The bench of these records has no history."""


def bare_texts(module: str) -> Iterator[int]:
    """Yield the lines in which a request is answered with a text that is no fact."""
    for node in ast.walk(ast.parse(module)):
        match node:
            case ast.Call(ast.Name(name), [first, *_]) if name in ERRORS:
                messages = [first]
            case ast.Call(ast.Name('Answer'), values, keywords):
                named = (keyword.value for keyword in keywords if keyword.arg == 'message')
                messages = [*values[1:2], *named]
            case ast.FunctionDef(returns=ast.Name('Decided' | '_Act')):
                messages = [
                    step.value.elts[0]
                    for step in ast.walk(node)
                    if isinstance(step, ast.Return) and isinstance(step.value, ast.Tuple)
                ]
            case _:
                continue
        if any(text for words in messages for text in _texts(words)):
            yield node.lineno


def _texts(node: ast.expr) -> Iterator[ast.expr]:
    """Yield texts in an expression, without those that a function is called with."""
    match node:
        case ast.Constant(str(text)) if not text.strip():
            return
        case ast.JoinedStr() | ast.Constant(str()):
            yield node
        case ast.List(parts):
            yield from (text for part in parts for text in _texts(part))
        case ast.BinOp(left, _, right):
            yield from (*_texts(left), *_texts(right))
        case ast.IfExp(_, body, other):
            yield from (*_texts(body), *_texts(other))
        case ast.Call(ast.Attribute(value, 'join' | 'format')):
            yield from (text for child in (value, *node.args) for text in _texts(child))


def test_no_request_is_answered_with_a_bare_text() -> None:
    files = [file for room in ROOMS for file in sorted(PACKAGE.glob(room))]
    assert len(files) > 100
    places = [
        f'{file.relative_to(ROOT)}:{line}'
        for file in files
        for line in bare_texts(file.read_text(encoding='utf-8'))
    ]
    assert places == [], 'make it a sentence of model/words'


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
        ("'\\n'.join([words, more])", False),
        ("'\\n'.join(['no', *more])", True),
        ('why_not, each', False),
    ],
)
def test_a_bare_text_is_found(argument: str, is_bare: bool) -> None:
    for module in (
        f'raise CommandRefused({argument})',
        f'answer = Answer(accepted=True, message=({argument}))',
        f'answer = Answer(True, ({argument}))',
        f'def decide() -> Decided: return ({argument}), ()',
    ):
        assert list(bare_texts(module)) == [1] * is_bare, module


@pytest.mark.parametrize('file', RECORDS, ids=lambda file: file.stem)
def test_each_answer_on_record_can_be_read(file: Path) -> None:
    answer = re.compile(r'^> .*?: (?:refused|accepted): (.*)$', re.MULTILINE)
    for message in answer.findall(file.read_text(encoding='utf-8')):
        if not any(words in message for words in WITHOUT_HISTORY):
            check_answer(message)


@pytest.mark.parametrize(
    'message',
    [
        'the robot is tired',
        'nothing was done; the robot is tired',
        'a1 gets no goal: the robot is tired',
    ],
)
def test_an_answer_in_other_words_is_seen(message: str) -> None:
    with pytest.raises(AssertionError):
        check_answer(message)
