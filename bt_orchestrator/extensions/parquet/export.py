"""The export: a folder with two tables."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path

from bt_orchestrator.extensions.parquet.rows import EVENTS, TASKS, TaskRows, event_row
from bt_orchestrator.extensions.parquet.table_file import TableFile
from bt_orchestrator.model.codec import known_event
from bt_orchestrator.view.report.account.steady_time import SteadyTime


class ParquetExport:
    """Writes `events.parquet` and `tasks.parquet`."""

    def __init__(
        self,
        folder: Path,
        history: str,
        steady: SteadyTime | None = None,
        starts: Iterable[int] = (),
    ) -> None:
        """Begin.

        :param history: of the journal; kept with the tables
        :param steady: what is known of the steps of its clock; None: what the records say
        :param starts: events with which a node was started
        :raises OSError: the folder cannot be written
        """
        folder.mkdir(parents=True, exist_ok=True)
        about = {'bt_orchestrator.history': history}
        self._events = TableFile(folder / 'events.parquet', EVENTS, about)
        self._tasks = TableFile(folder / 'tasks.parquet', TASKS, about)
        self._rows = TaskRows(steady or SteadyTime(), starts)

    def write(self, text: str) -> None:
        """Take in one record, as JSON."""
        record = json.loads(text)
        self._events.add(event_row(record))
        event = known_event(record)
        if event is not None:
            for row in self._rows.follow(event):
                self._tasks.add(row)

    def close(self) -> None:
        """Complete both files."""
        for row in self._rows.open():
            self._tasks.add(row)
        self._events.close()
        self._tasks.close()

    def discard(self) -> None:
        """Leave nothing unfinished behind."""
        self._events.discard()
        self._tasks.discard()
