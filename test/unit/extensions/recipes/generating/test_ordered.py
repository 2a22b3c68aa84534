"""Orders by recipe, read and generated in one process: `check` and `simulate`."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest
from fakes.action_types import FakeActionTypes
from fakes.glue_cell import CELL, RECIPE
from fakes.mistake_tables import table
from fakes.script_texts import mistakes
from fakes.shipped import ROOT

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.cli import bootstrap, check
from bt_orchestrator.cli.simulating import verb
from bt_orchestrator.extensions.recipes.generating import ordered
from bt_orchestrator.extensions.recipes.generating.inputs import Inputs
from bt_orchestrator.extensions.recipes.generating.making import Made, make
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.jobs.order import RecipeChoice
from bt_orchestrator.ports import MadeScript
from bt_orchestrator.script.cell_file import parse_cell
from bt_orchestrator.script.orders.order_file import named_places
from bt_orchestrator.script.script_file import parse_script

TYPES = FakeActionTypes()
NEWEST = RecipeChoice(('BOX-7',))
HERE = named_places('WO-1')


@pytest.fixture(scope='module', autouse=True)
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Work where a cell file and recipes are: two versions, and some that cannot be made."""
    with pytest.MonkeyPatch.context() as patch:
        here = tmp_path_factory.mktemp('orders')
        patch.chdir(here)
        recipes = here / 'recipes'
        recipes.mkdir()
        (here / 'cell.yaml').write_text(CELL)
        (recipes / 'box.yaml').write_text(RECIPE)
        (recipes / 'box.overrides.yaml').write_text('bind: {glue: robot_b}\n')
        (recipes / 'box_4.yaml').write_text(RECIPE.replace('version: 3', 'version: 4'))
        lid = RECIPE.replace('BOX-7', 'LID-1').replace('do: close', 'do: clse')
        (recipes / 'lid.yaml').write_text(lid)
        lines = RECIPE.replace('BOX-7', 'LID-2').replace('version: 3', 'version: 1').splitlines()
        lines[4:7] = lines[4], lines[6], lines[5].replace('glue}', 'glue, after: [close]}')
        (recipes / 'lid_2.yaml').write_text('\n'.join(lines) + '\n')
        (recipes / 'lid_2.overrides.yaml').write_text('bind: {glue: robot_a}\n')
        for name in ('twin_1', 'twin_2'):
            twin = RECIPE.replace('BOX-7', 'TWIN').replace('version: 3', 'version: 1')
            (recipes / f'{name}.yaml').write_text(twin)
        (recipes / 'notes.yaml').write_text('- no recipe\n')
        yield here


def maker() -> ordered.RecipeMaker:
    return ordered.RecipeMaker(parse_cell(CELL, 'cell', TYPES), TYPES, [Path('recipes')])


@pytest.mark.parametrize(('text', 'expected'), table('orders_by_recipe'))
def test_mistakes(text: str, expected: list[str]) -> None:
    Path('order.yaml').write_text(text)
    load = partial(
        bootstrap.load_jobs,
        [Path('order.yaml')],
        Path('cell.yaml'),
        [],
        TYPES,
        recipe_folders=[Path('recipes')],
    )
    assert mistakes(load) == expected


def made_at(choice: RecipeChoice, without: frozenset[str] = frozenset()) -> tuple[int, str]:
    """Return the version that is made, and who glues."""
    made = maker().make(choice, HERE, without)
    return made.made_from.version, made.generated.script.tasks['glue'].component


def test_order_binds_before_overrides_and_newest_version_wins() -> None:
    assert made_at(NEWEST) == (4, 'robot_a')
    assert made_at(RecipeChoice(('BOX-7',), 3)) == (3, 'robot_b')
    assert made_at(RecipeChoice(('BOX-7',), 3, {'glue': 'robot_a'})) == (3, 'robot_a')


def test_what_is_out_of_service_is_left_out() -> None:
    assert made_at(NEWEST, frozenset({'robot_a'})) == (4, 'robot_b')
    with pytest.raises(Refused, match='out of service'):
        made_at(NEWEST, frozenset({'robot_b'}))


def test_a_script_says_without_whom_it_was_made() -> None:
    """Only components count that could have done an operation (semantics 6.11)."""
    without = frozenset({'robot_a', 'belt'})
    made = maker().make(NEWEST, HERE, without)
    assert made.made_from.without == ('robot_a',)
    assert 'without: [robot_a]' in made.text
    given = maker().script(NEWEST, without)
    assert isinstance(given, MadeScript)
    read = parse_script(given.text, 'box.yaml', maker()._cell, TYPES)
    assert (digest(read), read.made_from) == (given.digest, given.made_from)
    assert 'without' not in maker().make(NEWEST, HERE).text.split('sections:')[0]


def test_script_is_made_once_until_inputs_change(monkeypatch: pytest.MonkeyPatch) -> None:
    times: list[frozenset[str]] = []

    def counted(inputs: Inputs, without: frozenset[str]) -> Made:
        times.append(without)
        return make(inputs, without)

    monkeypatch.setattr(ordered, 'make', counted)
    shelf = maker()
    first = shelf.make(NEWEST, HERE)
    assert shelf.make(NEWEST, HERE) is first
    assert shelf.make(RecipeChoice(('BOX-7', 'LID-2')), HERE) is first
    assert len(times) == 1
    for _ in range(2):
        shelf.make(RecipeChoice(('BOX-7',), bind={'glue': 'robot_b'}), HERE)
        shelf.make(NEWEST, HERE, frozenset({'robot_a'}))
    assert len(times) == 3
    for _ in range(2):
        with pytest.raises(Refused, match='LID-2 version 1 cannot be made'):
            shelf.make(RecipeChoice(('LID-2',)), HERE)
    assert len(times) == 4


def options(module: object, *words: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    module.add_arguments(parser)  # type: ignore[attr-defined]
    return parser.parse_args(words)


def test_check_says_what_an_order_comes_to(capsys: pytest.CaptureFixture[str]) -> None:
    Path('order.yaml').write_text('order: WO-7\nrecipe: BOX-7\nquantity: 3\n')
    words = ('order.yaml', '--cell', 'cell.yaml', '--recipes', 'recipes')
    assert check.check(options(check, *words), TYPES) == 0
    first, pace, *_ = capsys.readouterr().out.splitlines()
    assert first == 'WO-7: 3 items of box, made from recipe BOX-7 version 4, fits cell glue_cell'
    assert pace.startswith('  pace: ')
    assert check.check(options(check, *words, '--json'), TYPES) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer['orders'] == [
        {'order': 'WO-7', 'quantity': 3, 'script': 'box', 'recipe': 'BOX-7', 'version': 4}
    ]
    assert [entry['script'] for entry in answer['paces']] == ['box']


def test_the_shipped_order_by_recipe_is_simulated(capsys: pytest.CaptureFixture[str]) -> None:
    order, cell = (ROOT / 'config' / name for name in ('orders/wo_4001.yaml', CAPABLE))
    words = (str(order), '--cell', str(cell), '--recipes', str(ROOT / 'recipes'))
    assert verb.simulate(options(verb, *words), TYPES) == 0
    assert 'WO-4001  reference_process      3       3' in capsys.readouterr().out


CAPABLE = 'cell_with_capabilities.yaml'
