"""The sentences of the product: of its pages, messages, help and docstrings."""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path

from fakes.shipped import ROOT

from bt_orchestrator.cli.verbs import VERBS, actions_of, command_of, module_of

_CODE = re.compile(r'^( *)```.*?^\1```$', re.MULTILINE | re.DOTALL)
_GENERATED = re.compile(r'<!-- generated.*?<!-- end -->', re.DOTALL)
_PARAGRAPH = re.compile(r'\n[ \t]*\n|\n(?=[ \t]*(?:[-*|]|\d+\.)[ \t])|\n(?=\|)')
_SENTENCE = re.compile(r"(?<=[.!?])[\"')*]* +(?=[\"'(\[*`A-Z0-9…]|\w+: )")
_FEW_WORDS = 4
"""A text of fewer words is a label, a name or a key."""


def pages() -> dict[str, str]:
    """Return the text of the pages by name; decisions are records of their day."""
    paths = (ROOT / 'README.md', ROOT / 'CONTRIBUTING.md', *sorted((ROOT / 'docs').glob('*.md')))
    return {path.relative_to(ROOT).as_posix(): path.read_text(encoding='utf-8') for path in paths}


def written_by_hand(text: str) -> str:
    """Return a page without its code and its generated parts."""
    return without_generated(_CODE.sub('\n\n', text))


def without_generated(text: str) -> str:
    """Return a page without what is made from declarations."""
    return _GENERATED.sub('\n\n', text)


def sentences_of_page(text: str) -> Iterator[str]:
    """Yield the sentences of a page; inline code counts as one word.

    A part of a table's cell, up to a semicolon, is a paragraph.
    """
    for lines in _PARAGRAPH.split(written_by_hand(text)):
        paragraph = ' '.join(lines.split())
        if paragraph.startswith('#'):
            continue
        plain = re.sub(r'\[([^\]]*)\]\([^)]*\)', r'\1', re.sub(r'`[^`]*`', '`…`', paragraph))
        cells = re.split(r'\||; ', plain.strip('|')) if plain.startswith('|') else [plain]
        for cell in cells:
            yield from sentences(re.sub(r'^(?:[-*]|\d+\.) ', '', cell.strip()))


def sentences(text: str) -> Iterator[str]:
    """Yield the sentences of a paragraph."""
    yield from (sentence for sentence in _SENTENCE.split(' '.join(text.split())) if sentence)


@cache
def modules(folder: str = 'bt_orchestrator') -> dict[str, ast.Module]:
    """Return what is in each file of the package, or of a folder, by the path of the file."""
    paths = sorted((ROOT / folder).rglob('*.py'))
    return {
        path.relative_to(ROOT).as_posix(): ast.parse(path.read_text(encoding='utf-8'))
        for path in paths
    }


def long_test_names(module: ast.Module, most: int) -> Iterator[str]:
    """Yield the names of tests with more words; the numbers of the rule are none."""
    for node in _nodes(module):
        if isinstance(node, ast.FunctionDef) and node.name.startswith('test_'):
            words = [word for word in node.name.split('_')[1:] if not word.isdigit()]
            if len(words) > most:
                yield node.name


def first_lines(module: ast.Module) -> Iterator[str]:
    """Yield the first paragraph of each docstring, those of attributes included."""
    for text in _bare_texts(module).values():
        yield ' '.join(text.partition('\n\n')[0].split())


def messages(module: ast.Module) -> Iterator[str]:
    """Yield the texts in code that have a few words; a value in one counts as one word."""
    seen = set(_bare_texts(module))
    for node in _nodes(module):
        if isinstance(node, ast.JoinedStr):
            seen |= {id(part) for part in node.values}
            text = ''.join(
                str(part.value) if isinstance(part, ast.Constant) else '…' for part in node.values
            )
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            text = '' if id(node) in seen else node.value
        else:
            continue
        if len(text.split()) >= _FEW_WORDS:
            yield text


def variables(module: ast.Module) -> Iterator[str]:
    """Yield the names of variables and parameters; a field of a class is neither."""
    classes = (node for node in _nodes(module) if isinstance(node, ast.ClassDef))
    lines = (line for node in classes for line in node.body)
    fields = {id(line.target) for line in lines if isinstance(line, ast.AnnAssign)}
    for node in _nodes(module):
        if isinstance(node, ast.arg):
            yield node.arg
        elif (
            isinstance(node, ast.Name)
            and isinstance(node.ctx, ast.Store)
            and id(node) not in fields
        ):
            yield node.id


@cache
def _nodes(module: ast.Module) -> Sequence[ast.AST]:
    """Return all of a module, which takes longer than all that is done with it."""
    return tuple(ast.walk(module))


def _bare_texts(module: ast.Module) -> dict[int, str]:
    """Return the texts that stand alone: docstrings."""
    alone = (node.value for node in _nodes(module) if isinstance(node, ast.Expr))
    return {
        id(node): node.value
        for node in alone
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    }


def words_of_the_page() -> Iterator[str]:
    """Yield every English text of the operator page."""
    (path,) = (ROOT / 'bt_orchestrator').rglob('strings/en.json')
    return _texts_in(json.loads(path.read_text(encoding='utf-8')))


def _texts_in(value: object) -> Iterator[str]:
    if isinstance(value, dict):
        for part in value.values():
            yield from _texts_in(part)
    elif isinstance(value, str):
        yield value


def help_texts() -> dict[str, list[str]]:
    """Return the paragraphs of help by verb, as argparse has them."""
    return {verb: list(_help_of(verb)) for verb in VERBS}


def _help_of(verb: str) -> Iterator[str]:
    actions = actions_of(verb)
    if actions:
        yield from _paragraphs(module_of(verb).DESCRIPTION)
    for name in actions or ('',):
        parser = command_of([verb, name] if name else [verb]).parser()
        yield from _paragraphs(parser.description or '')
        yield from _paragraphs(parser.epilog or '')
        for option in parser._actions:
            yield from str(option.help or '').split('; ')  # the parts of a table cell


def _paragraphs(text: str) -> Iterator[str]:
    """Yield the paragraphs of a text; an indented line, and an exit status, is one of its own."""
    yield from re.split(r'\n\s*\n|\n(?= )|(?<=:)\n|\n(?=exit status)|, (?=\d )', text)


def package_file(path: str) -> str:
    """Return the name by which a ratchet knows a file; folders may be moved."""
    return Path(path).name
