"""The journals from which a feed copies: a file, or that of a running node."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.cli.journal_file import open_records
from bt_orchestrator.extensions.postgres.feed import Batch
from bt_orchestrator.model.codec import to_text
from bt_orchestrator.model.events import OrchestratorStarted
from bt_orchestrator.model.keeping.records import Extent, Record, Wanted
from bt_orchestrator.ports import CellLink, Records

MOST = 1000
"""Records of one transaction."""


class FileSource:
    """A journal file, whether a node has it or not."""

    def __init__(self, path: Path) -> None:
        """Open it.

        :raises JournalUnusable: it cannot be read
        """
        self._path = path
        self._records: Records = open_records(path)
        self._file = _file(path)

    @property
    def is_replaced(self) -> bool:
        """Tell whether another file has its name now."""
        return _file(self._path) != self._file

    def close(self) -> None:
        """Close it."""
        self._records.close()

    def extent(self) -> Extent:
        """Return the history and the range of its events."""
        return self._records.extent()

    def after(self, seq: int) -> Batch:
        """Return the next records after an event."""
        page = self._records.page(Wanted(after_seq=seq), MOST)
        reached = max(page.rest.after_seq, page.first_seq - 1)
        return Batch(page.history, page.records, reached, page.first_seq, page.is_last)

    def starts(self) -> Iterator[tuple[int, str]]:
        """Yield each start of a node, and the history that it names."""
        wanted, is_last = Wanted(events=(OrchestratorStarted.event,)), False
        while not is_last:
            page = self._records.page(wanted)
            for seq, text in page.records:
                yield seq, str(json.loads(text).get('history', ''))
            wanted, is_last = page.rest, page.is_last

    def cell_name(self) -> str:
        """Return the cell that the last node named; empty: none has."""
        wanted = Wanted(events=(OrchestratorStarted.event,), newest_first=True)
        while True:
            page = self._records.page(wanted, 1)
            for record in page.records:
                return str(json.loads(record.text)['cell'])
            if page.is_last:
                return ''
            wanted = page.rest


class DoorSource:
    """The journal of a running node, over its door."""

    def __init__(self, door: CellLink) -> None:
        self._door = door

    @property
    def is_replaced(self) -> bool:
        """A node that comes back has the same door."""
        return False

    def close(self) -> None:
        """Leave."""
        self._door.close()

    def extent(self) -> Extent:
        """Return the history and the range of its events."""
        page = self._door.events_after(0, 1)
        return Extent(page.history, page.first_seq, page.last_seq)

    def after(self, seq: int) -> Batch:
        """Return the next records after an event."""
        page = self._door.events_after(seq)
        records = [Record(event.seq, to_text(event)) for event in page.events]
        reached = records[-1].seq if records else max(seq, page.first_seq - 1)
        return Batch(page.history, records, reached, page.first_seq, not records)

    def starts(self) -> Iterator[tuple[int, str]]:
        """Yield each start of a node, and the history that it names."""
        seq = 0
        while events := self._door.events_after(seq).events:
            for event in events:
                if isinstance(event, OrchestratorStarted):
                    yield event.seq, event.history
            seq = events[-1].seq

    def cell_name(self) -> str:
        """Return the name of the cell."""
        return self._door.description().cell


def _file(path: Path) -> tuple[int, int]:
    try:
        status = path.stat()
    except OSError as error:
        raise JournalUnusable(f'there is no journal {path}; check the path') from error
    return status.st_dev, status.st_ino
