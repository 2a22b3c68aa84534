"""The files of the page as the tests read them."""

import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

import bt_orchestrator.extensions.page.web

STATIC = Path(bt_orchestrator.extensions.page.web.__file__).parent / 'static'
LANGUAGES = ('en', 'de')

_KEY = re.compile(r'\b(?:t|tOr|has)\(\s*(?:[^()\'`]*\?\s*)?[\'`]([\w.]*(?:\$\{)?)')


def modules() -> list[Path]:
    """Return all modules of the page."""
    return sorted(STATIC.rglob('*.js'))


def words(language: str) -> Mapping[str, object]:
    """Return the words of a language by key."""
    groups = json.loads((STATIC / 'strings' / f'{language}.json').read_text(encoding='utf-8'))
    return {f'{group}.{name}': text for group, own in groups.items() for name, text in own.items()}


def keys_asked_for() -> Iterator[tuple[Path, str]]:
    """Yield where words are asked for, and the key; one with a variable ends where that begins."""
    for path in modules():
        for key in _KEY.findall(path.read_text(encoding='utf-8')):
            yield path, key
