"""`submit` and `queue add` name every mistake that `check` names, at the same places."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from pathlib import Path

import pytest
from fakes.line import THREE, TYPES, Line, expanded
from fakes.operator import engineer

from bt_orchestrator.base.errors import NodeUnreachable, Refused
from bt_orchestrator.cli.check import add_arguments, check
from bt_orchestrator.cli.door import instead_of_a_door
from bt_orchestrator.cli.main import main
from bt_orchestrator.model import events as e
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.requests import Asked
from bt_orchestrator.sim.virtual_link import VirtualLink, VirtualNode
from bt_orchestrator.store.memory import MemoryStore

SCRIPT = """
params:
  lot: {type: str}
  n: {type: int, default: 3}
  bright: {type: bool, default: true}
"""

FINE = 'order: A\nscript: test\nquantity: 2\nparams: {lot: A7}\n'

WRONG = {
    'of the script': (
        'order: A\nscript: test\nquantity: 20000\nparams:\n  n: many\n  brigt: true\n'
    ),
    'of the file': 'order: A/1\nscript: test\nquantity: 0\npriority: high\nparams: {lot: A7}\n',
    'of both': (
        'order: A\nscript: test\nquantity: none\nstart: tomorrow\nparams:\n  lot: [1]\n  n: many\n'
        '  brigt: true\n'
    ),
    'of both, without an id': (
        'script: test\nquantity: 2\npriority: high\nparams: {bright: maybe}\n'
    ),
    'script': 'order: A\nscript: tset\nquantity: 2\nparams: {lot: A7}\n',
    'script and file': 'order: A\nscript: tset\nquantity: none\n',
    'no script': 'order: A\nquantity: none\nparams: {lot: [1]}\n',
    'names with dots and colons': (
        'order: A\nscript: test\nquantity: 1\nparams:\n  lot: A7\n  "a.b:1:1: c": 1\n'
        f'  {"x" * 80}: 2\n'
    ),
}
"""Orders with mistakes."""


class SignedLink(VirtualLink):
    """A link of somebody whose name is known."""

    def ask(self, asked: Asked) -> Answer:
        return super().ask(replace(asked, by=engineer('Ann', reason='')))


class NoNode(AbstractContextManager['NoNode']):
    """A door behind which no node is."""

    def __exit__(self, *_: object) -> None: ...

    def ask(self, asked: Asked) -> Answer:
        raise NodeUnreachable('no node')


@pytest.fixture
def store() -> MemoryStore:
    return MemoryStore()


@pytest.fixture(autouse=True)
def _cell(tmp_path: Path, store: MemoryStore, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.chdir(tmp_path)
    line = Line()
    trees = Path('trees')
    trees.mkdir()
    (trees / 'test.yaml').write_text(expanded(f'script: test{SCRIPT}{THREE}'))
    Path('cell.yaml').write_text(line.text)
    node = VirtualNode(line.cell, line.types, [trees.absolute()])
    node.switch_on(store)
    with instead_of_a_door(nullcontext(SignedLink(node))):
        yield


def written(*texts: str) -> list[str]:
    files = [f'{number}.yaml' for number in range(len(texts))]
    for file, text in zip(files, texts, strict=True):
        Path(file).write_text(text)
    return files


def checked(files: Sequence[str]) -> list[str]:
    """Return what `check` prints of some orders."""
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    given = parser.parse_args(
        [*files, '--cell', 'cell.yaml', '--trees', str(Path('trees').absolute())]
    )
    with pytest.raises(Refused) as refused:
        check(given, TYPES)
    return [str(finding) for finding in refused.value.findings]


def told(
    capsys: pytest.CaptureFixture[str], words: Sequence[str], files: Sequence[str]
) -> list[str]:
    """Return the mistakes that a verb prints."""
    assert main([*words, *files]) == 1
    lines = capsys.readouterr().err.splitlines()
    return [line for line in lines if line.startswith(tuple(files))]


@pytest.mark.parametrize('words', [['submit'], ['queue', 'add']])
@pytest.mark.parametrize('text', [pytest.param(WRONG[name], id=name) for name in WRONG])
def test_every_mistake_is_named_with_its_line(
    capsys: pytest.CaptureFixture[str], text: str, words: list[str], store: MemoryStore
) -> None:
    files = written(text)
    assert sorted(told(capsys, words, files)) == sorted(checked(files))
    assert not any(isinstance(event, e.JobQueued) for event in store.read())


def test_mistakes_of_several_files_queue_nothing(
    capsys: pytest.CaptureFixture[str], store: MemoryStore
) -> None:
    other = WRONG['of the script'].replace('order: A', 'order: B')
    for texts in (
        [FINE, FINE],
        [FINE, other],
        [WRONG['of both'], other],
        [WRONG['no script'], FINE],
    ):
        files = written(*texts)
        assert sorted(told(capsys, ['submit'], files)) == sorted(checked(files))
    assert not any(isinstance(event, e.JobQueued) for event in store.read())
    assert main(['submit', *written(FINE)]) == 0
    assert [event.job for event in store.read() if isinstance(event, e.JobQueued)] == ['A']


def test_file_mistakes_are_reported_without_node(
    capsys: pytest.CaptureFixture[str],
) -> None:
    files = written(WRONG['of both'])
    with instead_of_a_door(NoNode()):
        assert main(['submit', *files]) == 1
    note, *lines = capsys.readouterr().err.splitlines()
    assert note == 'no node; mistakes that only the node can find are not listed here'
    assert [line.split(':')[1] for line in lines] == ['3', '4', '6']
