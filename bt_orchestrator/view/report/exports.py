"""Records of a journal in the formats that the verb `events` offers."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from datetime import datetime
from typing import IO, Protocol, runtime_checkable

from bt_orchestrator.view.report.account.steady_time import SteadyTime
from bt_orchestrator.view.report.csv_export import LEFT_OUT, CsvExport
from bt_orchestrator.view.report.tables import shown
from bt_orchestrator.view.report.xes_export import XesExport

_SHOWN_FIRST = ('seq', 'time', 'event', 'job', 'section', 'item', 'task')


class Output(Protocol):
    """One format of records.

    One that writes everything at its end declares `at_end = True`: it cannot follow a journal.
    """

    def write(self, text: str) -> None:
        """Take in one record, as JSON."""

    def close(self) -> None:
        """Write what is still to be written."""


@runtime_checkable
class Timed(Protocol):
    """An output that needs to know how the clock was set, also before its first record."""

    def take_steps(self, steady: SteadyTime) -> None:
        """Take what is known of the steps of the clock; called before the first record."""


class JsonLines:
    """Records unchanged, one a line."""

    def __init__(self, file: IO[str]) -> None:
        self._file = file

    def write(self, text: str) -> None:
        """Write one record."""
        self._file.write(text + '\n')

    def close(self) -> None:
        """Do nothing: every line is complete."""


class Text(JsonLines):
    """Records for a person, one a line, times as on the wall."""

    def write(self, text: str) -> None:
        """Write one record."""
        record = json.loads(text)
        moment = datetime.fromtimestamp(record['time']).isoformat(' ', timespec='milliseconds')
        place = [f'section {record["section"]}'] if 'section' in record else []
        place += [str(record[n]) for n in ('item', 'task') if n in record]
        if 'item' not in record and 'job' in record:
            place.insert(0, record['job'])
        more = [
            f'{name}={shown(value)}'
            for name, value in record.items()
            if name not in (*_SHOWN_FIRST, *LEFT_OUT)
        ]
        line = f'{moment}  #{record["seq"]:<6} {record["event"]:<21} {" ".join([*place, *more])}'
        super().write(line.rstrip())


OUTPUTS: Mapping[str, Callable[[IO[str]], Output]] = {
    'text': Text,
    'jsonl': JsonLines,
    'csv': CsvExport,
    'xes': XesExport,
}
