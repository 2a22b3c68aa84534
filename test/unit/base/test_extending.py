"""The table of extensions: that of setup.py says the same, and no contract forgets one."""

from __future__ import annotations

import ast
import sys
from pathlib import Path

import pytest

from bt_orchestrator import extensions
from bt_orchestrator.base.extending import EXTENSIONS, PAGE, RECIPES, Extension, ExtensionMissing
from bt_orchestrator.cli.verbs import VERBS
from bt_orchestrator.extensions.recipes.generating import extension
from bt_orchestrator.script.orders.by_recipe import Recipes

ROOT = Path(__file__).parents[3]


def test_the_extras_are_the_extensions() -> None:
    (extras,) = (
        ast.literal_eval(node.value)
        for node in ast.walk(ast.parse((ROOT / 'setup.py').read_text()))
        if isinstance(node, ast.keyword) and node.arg == 'extras_require'
    )
    del extras['test']
    assert extras.pop('signed') == ['cryptography>=40'], 'the core signs with it, if it is there'
    assert extras == {entry.name: list(entry.packages.values()) for entry in EXTENSIONS}


@pytest.mark.parametrize('extension', EXTENSIONS, ids=lambda case: case.name)
def test_none_is_forgotten_by_the_contract(extension: Extension) -> None:
    contracts = (ROOT / 'pyproject.toml').read_text()
    contract = contracts.split('id = "extensions"')[1].partition('[[')[0]
    assert 'independence' in contract
    assert f'"{extension.room}"' in contract
    assert not extension.verb or extension.verb in VERBS


def test_extension_folders_match_the_table() -> None:
    folder = Path(extensions.__file__).parent
    names = {entry.name for entry in folder.iterdir() if (entry / '__init__.py').exists()}
    assert names == {entry.name for entry in EXTENSIONS}


def test_recipes_are_what_the_core_asks_for() -> None:
    recipes: Recipes = extension  # mypy compares them
    assert recipes is extension


def test_missing_package_error_names_install_command(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, 'uvicorn', None)
    with pytest.raises(ExtensionMissing) as raised:
        PAGE.demand()
    assert str(raised.value) == (
        'page: uvicorn cannot be imported; install what the operator page needs with: '
        "pip install 'starlette>=0.31' 'uvicorn>=0.27', or on Ubuntu: "
        'apt install python3-starlette python3-uvicorn'
    )
    PAGE.demand(with_packages=False)


def test_a_room_that_is_missing_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, RECIPES.room, None)
    with pytest.raises(ExtensionMissing, match=f'{RECIPES.room} cannot be imported'):
        RECIPES.demand(with_packages=False)
