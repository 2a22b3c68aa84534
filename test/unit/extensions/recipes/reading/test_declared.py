"""What recipes declare for their orders."""

from __future__ import annotations

from pathlib import Path

import pytest
from fakes.shipped import RECIPES

from bt_orchestrator.script.declared import OrderFiles
from bt_orchestrator.script.orders.by_recipe import DeclaredRecipe


def recipes(*folders: Path) -> list[DeclaredRecipe]:
    return OrderFiles((), folders).recipes()


HEAD = 'recipe: {}\nversion: {}\nscript: s\nparams: {{{}: {{type: str}}}}\noperations: []\n'


def test_newest_version_of_recipe_declares_its_parameters(tmp_path: Path) -> None:
    for file, *about in (
        ('a_2', 'A', 2, 'new'),
        ('a_1', 'A', 1, 'old'),
        ('b', 'B', 7, 'lot'),
        ('b.overrides', 'B', 8, 'never'),
        ('broken', 'C', 1, '1.2.3: ['),
    ):
        (tmp_path / f'{file}.yaml').write_text(HEAD.format(*about))
    declared = {
        recipe.name: {version.version: list(version.params) for version in recipe.versions}
        for recipe in recipes(tmp_path)
    }
    assert declared == {'A': {1: ['old'], 2: ['new']}, 'B': {7: ['lot']}}
    assert [list(recipe.newest.params) for recipe in recipes(tmp_path)] == [['new'], ['lot']]


@pytest.mark.parametrize(('broken', 'versions'), [(1, [[2]]), (2, [])])
def test_recipe_with_faulty_newest_version_is_not_orderable(
    tmp_path: Path, broken: int, versions: list[list[int]]
) -> None:
    for version in (1, 2):
        params = 'no.name' if version == broken else 'lot'
        (tmp_path / f'{version}.yaml').write_text(HEAD.format('A', version, params))
    assert [
        [entry.version for entry in recipe.versions] for recipe in recipes(tmp_path)
    ] == versions


def test_operations_declare_what_they_do(tmp_path: Path) -> None:
    listed = '[{id: a, do: glue}, {repeat: [{id: b, do: [tape, glue]}], times: 1}, {do: glue}, 7]'
    text = HEAD.format('A', 1, 'lot').replace('operations: []', f'operations: {listed}')
    (tmp_path / 'a.yaml').write_text(text)
    (recipe,) = recipes(tmp_path)
    assert recipe.newest.operations == {'a': ('glue',), 'b': ('tape', 'glue')}


def test_the_first_folder_has_a_version(tmp_path: Path) -> None:
    for folder, name in (('first', 'a'), ('second', 'b')):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / 'r.yaml').write_text(HEAD.format('A', 1, name))
    (recipe,) = recipes(tmp_path / 'first', tmp_path / 'second', tmp_path / 'none')
    assert list(recipe.newest.params) == ['a']


def test_shipped_recipes_are_found() -> None:
    parameters = {recipe.name: list(recipe.newest.params) for recipe in recipes(RECIPES)}
    assert parameters['WM-100'] == ['label']
    assert 'GM-37' in parameters
