"""How long a report of a year takes, by the books of its journal and without them."""

from __future__ import annotations

import re
import resource
import sqlite3
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path
from typing import NamedTuple

from fakes.hand_made_shift import LINE, the_day
from fakes.kept_books import book_all

from bench.rows import Row
from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import to_text
from bt_orchestrator.store.shared.database import check_of_event
from bt_orchestrator.store.sqlite.database import transaction
from bt_orchestrator.store.sqlite.store import SqliteStore

YEAR_S = 365 * 24 * 3600.0
BEGIN_S = 1_767_225_600.0
"""New year of 2026."""

_SCRIPT = '"event": "script.loaded"'

MOST_WITHOUT_BOOKS = 1_000_000
"""Events of a journal whose report is made from the events alone, too."""


def report(rounds: int, events: int) -> Iterator[Row]:
    """Report a journal of a year: shift after shift of one hand-made shift, all through it."""
    with tempfile.TemporaryDirectory(prefix='bench_') as name:
        journal = Path(name) / 'year.sqlite3'
        number = write_year(journal, events)
        cell = Path(name) / 'cell.yaml'
        cell.write_text(LINE.text)
        alone = _report(journal, cell) if number <= MOST_WITHOUT_BOOKS else None
        began = time.process_time()
        with closing(SqliteStore(journal)) as store:
            book_all(store, journal)
        books_s, size = time.process_time() - began, _size_of_books(journal)
        runs = [_report(journal, cell) for _ in range(rounds)]
    notes = {
        'events': number,
        'report, CPU s': min(run.cpu_s for run in runs),
        'report, MB of memory': max(run.mb for run in runs),
        'books, MB': size / 1e6,
        'making them, CPU s': books_s,
        'making them, events a second': number / books_s,
    }
    if alone is not None:
        notes |= {'without books, s': alone.seconds, 'without books, MB of memory': alone.mb}
    yield Row('report', [run.seconds for run in runs], notes)


class _Run(NamedTuple):
    seconds: float
    cpu_s: float
    mb: float


def _report(journal: Path, cell: Path) -> _Run:
    """Run the verb in a process, as a user does."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    began = time.perf_counter()
    command = [sys.executable, '-m', 'bench.peak', '-m', 'bt_orchestrator', 'report']
    made = subprocess.run(
        [*command, '--journal', str(journal), '--cell', str(cell), '--json'],
        capture_output=True,
        text=True,
        check=True,
    )
    seconds = time.perf_counter() - began
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return _Run(seconds, cpu_s, int(made.stderr.split()[-1]) / 1024)


def _size_of_books(journal: Path) -> int:
    """Return the bytes of their texts."""
    with closing(sqlite3.connect(journal)) as database:
        return sum(
            int(database.execute(f'SELECT sum(length({text})) FROM book_{text}s').fetchone()[0])
            for text in ('slot', 'state', 'script')
        )


def write_year(path: Path, events: int) -> int:
    """Write a journal of a year of about so many events; returns how many they are."""
    SqliteStore(path).close()
    sample = the_day().events
    sample.append(e.JobCompleted(job='J').stamped(0, sample[-1].time))
    day = [(event.time, re.sub(r'^.*?"event"', '"event"', to_text(event))) for event in sample]
    first, last = day[0][0], day[-1][0]
    shifts = max(1, round(events / len(day)))
    pace = YEAR_S / shifts / (last - first)
    seq = 0
    with closing(sqlite3.connect(path, isolation_level=None)) as database:
        for shift in range(shifts):
            begin = BEGIN_S + YEAR_S * shift / shifts
            parts = [
                (begin + (moment - first) * pace, text)
                for moment, text in day
                if not shift or _SCRIPT not in text
            ]
            seq = _write(database, parts, shift, seq)
    return seq


def _write(
    database: sqlite3.Connection, parts: Sequence[tuple[float, str]], shift: int, seq: int
) -> int:
    rows = []
    for moment, text in parts:
        seq += 1
        names = text.replace('"J', f'"J{shift}').replace('"hold": "', f'"hold": "{shift}-')
        record = f'{{"seq": {seq}, "time": {moment:.3f}, {names}'
        rows.append((seq, record, check_of_event(seq, record.encode(), 1), 1))
    with transaction(database):
        database.executemany('INSERT INTO events VALUES (?, ?, ?, ?)', rows)
    return seq
