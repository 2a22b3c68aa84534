"""The patches of test/mutations fit the package, and break a rule that has tests."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]


def _load() -> ModuleType:
    spec = importlib.util.spec_from_file_location('mutations', ROOT / 'test/mutations/run.py')
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


MUTATIONS = _load()


@pytest.fixture(scope='module')
def tested() -> set[str]:
    """Rules that the names of the tests name."""
    files = (file for part in MUTATIONS.TESTS for file in (ROOT / part).glob('test_*.py'))
    texts = [file.read_text() for file in files]
    numbers = re.findall(r'(?m)^def test_(\d)_(\d+)_', '\n'.join(texts))
    return {f'{chapter}.{rule}' for chapter, rule in numbers}


def test_every_patch_applies(tmp_path: Path) -> None:
    MUTATIONS.copy_package(tmp_path)
    broken = [
        p.name for p in MUTATIONS.patches() if not MUTATIONS.applies(p, tmp_path, check=True)
    ]
    assert broken == []
    assert len(MUTATIONS.patches()) > 40


def test_every_patch_names_a_rule_that_has_tests(tested: set[str]) -> None:
    assert {MUTATIONS.rule_of(patch) for patch in MUTATIONS.patches()} <= tested


def test_every_rule_of_the_line_has_a_test(tested: set[str]) -> None:
    chapters = {2: range(2, 8), 3: range(1, 9), 4: range(1, 5), 5: (1, 2), 6: range(1, 6)}
    rules = {f'{chapter}.{rule}' for chapter, some in chapters.items() for rule in some}
    assert rules | {'7.1', '7.3', '7.4'} <= tested
