"""The rules of the line and the tests that are named after them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from tables.markdown import table

_ROOT = Path(__file__).resolve().parents[2]
_RULE_TEST = re.compile(r'^def (?:test)?_(\d)_(\d+)_', re.MULTILINE)
"""A test, or a step of a test, such as `_7_1_a_removal_is_recorded`."""


def tests_of_the_rules() -> Iterator[str]:
    """Yield a table of the rules with the files whose tests are named after them."""
    files: dict[tuple[int, int], set[Path]] = {}
    for path in (_ROOT / 'test').rglob('test_*.py'):
        for chapter, rule in _RULE_TEST.findall(path.read_text(encoding='utf-8')):
            files.setdefault((int(chapter), int(rule)), set()).add(path)
    yield from table(
        ('rule', 'tests named after it'),
        (
            (f'{chapter}.{rule}', ', '.join(map(_link, sorted(paths))))
            for (chapter, rule), paths in sorted(files.items())
        ),
    )


def _link(path: Path) -> str:
    return f'[{path.stem}](../{path.relative_to(_ROOT).as_posix()})'
