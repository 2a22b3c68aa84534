"""Pages of a few tasks in every tree, so that small lines have them as well."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from bt_orchestrator.engine.tree import section


@contextmanager
def small_pages(tasks: int) -> Iterator[None]:
    """Have every list in pages of so many tasks; 0: as ever."""
    with pytest.MonkeyPatch.context() as patch:
        if tasks:
            patch.setattr(section, 'MOST_WHOLE', 0)
            patch.setattr(section, 'PAGE', tasks)
        yield
