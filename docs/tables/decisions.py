"""The decision records."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

_FOLDER = Path(__file__).resolve().parents[1] / 'decisions'


def decisions() -> Iterator[str]:
    """Yield a list of the records with their titles."""
    for path in sorted(_FOLDER.glob('[0-9]*.md')):
        title = path.read_text(encoding='utf-8').partition('\n')[0]
        words = re.sub(r'^# (\d+\W+)?', '', title).rstrip('.')
        yield f'- [{path.name[:4]}]({path.name}) {words}'
    yield ''
