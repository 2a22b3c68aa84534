"""The shipped files name their schemas, and editors have nothing against them."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from fakes.schemas import SCHEMAS, refusals
from fakes.shipped import ROOT

CELLS = [path for path in (ROOT / 'config').glob('*.yaml') if path.name != 'tree_node.yaml']
OVERRIDES = list((ROOT / 'recipes').glob('*.overrides.yaml'))
RECIPES = [path for path in (ROOT / 'recipes').glob('*.yaml') if path not in OVERRIDES]
FILES = {
    'cell.schema.json': CELLS,
    'script.schema.json': list((ROOT / 'trees').glob('*.yaml')),
    'recipe.schema.json': RECIPES,
    'overrides.schema.json': OVERRIDES,
    'shifts.schema.json': list((ROOT / 'config' / 'shifts').glob('*shifts.yaml')),
    'reasons.schema.json': list((ROOT / 'config' / 'shifts').glob('*reasons.yaml')),
    'work_order.schema.json': list((ROOT / 'config' / 'orders').glob('*.yaml')),
}


@pytest.mark.parametrize(
    ('schema', 'path'),
    [(schema, path) for schema, paths in FILES.items() for path in paths],
    ids=lambda value: value.name if isinstance(value, Path) else value,
)
def test_shipped_file_names_and_fits_its_schema(schema: str, path: Path) -> None:
    text = path.read_text(encoding='utf-8')
    named = re.match(r'# yaml-language-server: \$schema=(\S+)\n', text)
    assert named is not None
    assert (path.parent / named[1]).resolve() == SCHEMAS / schema
    assert refusals(schema, text) == []


def test_every_file_kind_ships_with_its_schema() -> None:
    assert {path.name for path in SCHEMAS.iterdir()} == {*FILES}
    assert all(FILES.values())
