"""What recipes declare for their orders."""

from __future__ import annotations

from pathlib import Path

from fakes.shipped import RECIPES

from bt_orchestrator.script.recipes.declared import declared_recipes

HEAD = 'recipe: {}\nversion: {}\nscript: s\nparams: {{{}: {{type: str}}}}\noperations: []\n'


def test_the_newest_version_of_each_recipe_declares_its_parameters(tmp_path: Path) -> None:
    for file, *about in (
        ('a_2', 'A', 2, 'new'),
        ('a_1', 'A', 1, 'old'),
        ('b', 'B', 7, 'lot'),
        ('b.overrides', 'B', 8, 'never'),
        ('broken', 'C', 1, '1.2.3: ['),
    ):
        (tmp_path / f'{file}.yaml').write_text(HEAD.format(*about))
    found = {one.name: (one.versions, list(one.params)) for one in declared_recipes([tmp_path])}
    assert found == {'A': ((1, 2), ['new']), 'B': ((7,), ['lot'])}


def test_the_first_folder_has_a_version(tmp_path: Path) -> None:
    for folder, name in (('first', 'a'), ('second', 'b')):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / 'r.yaml').write_text(HEAD.format('A', 1, name))
    (found,) = declared_recipes([tmp_path / 'first', tmp_path / 'second', tmp_path / 'none'])
    assert list(found.params) == ['a']


def test_shipped_recipes_are_found() -> None:
    found = {one.name: list(one.params) for one in declared_recipes([RECIPES])}
    assert found['WM-100'] == ['label']
    assert 'GM-37' in found
