"""The verb `new-cell`: its files can be checked, drawn and simulated at once."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import pytest
from fakes.action_types import FakeActionTypes

from bt_orchestrator.cli import check, new_cell, render
from bt_orchestrator.cli.new_cell import NothingWritten
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.cli.simulating import verb
from bt_orchestrator.extensions.recipes.generating import verb as generate

TYPES = FakeActionTypes()


def options(module: object, *words: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    module.add_arguments(parser)  # type: ignore[attr-defined]
    return parser.parse_args(words)


def write(*words: str) -> int:
    return new_cell.new_cell(options(new_cell, *words), (), TYPES)


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize('sections', ['1', '2', '6'])
def test_the_files_work_as_they_are(
    sections: str, here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert write('mine', '--sections', sections) == 0
    assert 'next: cd mine && bt-orchestrator check first_product' in capsys.readouterr().out
    monkeypatch.chdir(here / 'mine')
    cell = ('--cell', 'cell.yaml')
    assert check.check(options(check, 'first_product', *cell), TYPES) == 0
    drawing = options(render, 'first_product', *cell, '-o', 'drawing.svg')
    assert render.render(drawing, TYPES) == 0
    assert verb.simulate(options(verb, 'order.yaml', *cell), TYPES) == 0
    assert 'first_product      3       3 ' in capsys.readouterr().out


@pytest.mark.parametrize('sections', ['1', '4'])
def test_files_with_recipe_work_as_written(
    sections: str, here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert write('mine', '--sections', sections, '--recipe') == 0
    monkeypatch.chdir(here / 'mine')
    cell, file = ('--cell', 'cell.yaml'), 'trees/first_product.yaml'
    words = options(generate, 'recipes/first_product.yaml', *cell, '--check', file)
    assert generate.generate(words, TYPES) == 0
    assert check.check(options(check, 'first_product', *cell, '--strict'), TYPES) == 0
    assert verb.simulate(options(verb, 'order.yaml', *cell), TYPES) == 0
    assert 'first_product      3       3 ' in capsys.readouterr().out
    recipe = Path('recipes/first_product.yaml').read_text()
    schema = Path('recipes') / recipe.partition('\n')[0].partition('$schema=')[2]
    assert json.loads(schema.read_text())['title']


def test_moved_files_still_find_their_schemas(here: Path) -> None:
    write('mine', '--sections', '2')
    assert len([*(here / 'mine' / 'schemas').iterdir()]) == 3
    moved = here / 'mine'
    moved = moved.rename(here / 'elsewhere')
    files = list(moved.rglob('*.yaml'))
    assert len(files) == 3
    for path in files:
        first = path.read_text().partition('\n')[0]
        schema = Path(first.removeprefix('# yaml-language-server: $schema='))
        assert not schema.is_absolute()
        assert json.loads((path.parent / schema).read_text())['title']


def test_nothing_is_overwritten(here: Path) -> None:
    write('mine', '--sections', '2', '-o', 'here')
    order = here / 'here' / 'order.yaml'
    order.write_text('mine')
    (here / 'here' / 'cell.yaml').unlink()
    with pytest.raises(NothingWritten, match=r'here/order\.yaml exist already, .* with -o'):
        write('mine', '--sections', '3', '-o', 'here')
    assert order.read_text() == 'mine'
    assert not (here / 'here' / 'cell.yaml').exists()


def test_a_folder_that_cannot_be_made_is_named(here: Path) -> None:
    (here / 'file').write_text('')
    with pytest.raises(NothingWritten, match=r'cannot write file/.*: .*'):
        write('mine', '--sections', '2', '-o', 'file/inside')


@pytest.mark.parametrize(
    ('words', 'message'),
    [
        (['2x', '--sections', '2'], '`2x` cannot be a cell name.*`cell_2x`'),
        (['a b', '--sections', '2'], '`a_b`'),
        (['lines/mine', '--sections', '2'], 'write for instance `mine -o lines/mine`'),
        (['lines/1', '--sections', '2'], '`lines_1`'),
        (['mine', '--sections', '0'], 'from 1 to 1000, not 0'),
        (['mine', '--sections', '1001'], 'from 1 to 1000, not 1001'),
    ],
)
def test_wrong_use(words: list[str], message: str, here: Path) -> None:
    with pytest.raises(WrongUse, match=message):
        write(*words)
    assert [*here.iterdir()] == []
