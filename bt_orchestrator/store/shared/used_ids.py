"""Sealed parts of the ids that were ever used, which states in the journal name (decision 0042).

The events that they came from may have been removed, so each part is there twice.
"""

from __future__ import annotations

import logging

from bt_orchestrator.model.judging.sealed_ids import SealedIds, digest_of
from bt_orchestrator.store.shared.database import Database, replace

log = logging.getLogger(__name__)

COPIES = (1, 2)


def keep(database: Database, part: SealedIds) -> None:
    """Write a part; it takes the place of one that is damaged."""
    rows = [(part.digest, copy, part.text) for copy in COPIES]
    replace(database, 'used_ids', 'digest, copy', 'ids', rows)


def sound_copies(database: Database, digest: str) -> list[str]:
    """Return the text of a part, once for each copy that is whole."""
    found = [_read(database, digest, copy) for copy in COPIES]
    sound = [text for text in found if text is not None]
    if len(sound) < len(COPIES):
        log.warning(
            'the journal has %d of %d copies of the used ids %s', len(sound), len(COPIES), digest
        )
    return sound


def _read(database: Database, digest: str, copy: int) -> str | None:
    """Return the text of one copy; None: it is not there, or damaged."""
    query = 'SELECT CAST(ids AS BLOB) FROM used_ids WHERE digest = ? AND copy = ?'
    try:
        row = database.execute(query, (digest, copy)).fetchone()
        text = None if row is None else row[0].decode()
    except (database.Error, UnicodeDecodeError):
        return None
    return text if text is not None and digest_of(text) == digest else None
