"""A journal in a file, read as the verbs do."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from bt_orchestrator.store.sqlite.records import SqliteRecords
from bt_orchestrator.view.report.reading import Reading

log = logging.getLogger(__name__)


@contextmanager
def journal_reading(path: Path, tell: Callable[[str], None] = log.warning) -> Iterator[Reading]:
    """Open a journal for as long as it is read."""
    with closing(SqliteRecords(path)) as records:
        yield Reading(records, tell)
