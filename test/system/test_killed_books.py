"""Books while whoever makes them or keeps them is killed: reports stay the same."""

from __future__ import annotations

import json
import os
import shutil
import signal
from collections.abc import Callable
from contextlib import closing, suppress
from functools import partial
from pathlib import Path

import pytest
from cell_processes import StartCell
from fakes.line import Line
from fakes.long_journal import make_long_journal

from bt_orchestrator.store.sqlite.records import SqliteRecords
from bt_orchestrator.view.report.account.account import Account, account
from bt_orchestrator.view.report.account.period import Period
from bt_orchestrator.view.report.account.plain import account_plain
from bt_orchestrator.view.report.reading import Reading

LINE = Line()
EVENTS = 8_000
TOLD = 'the books of the account cannot be made (the process ended by signal SIGKILL)'
PROCESS = 'bt_orchestrator.cli.processes.bookkeeping_process'


def report(journal: Path, period: Period) -> Account:
    with closing(SqliteRecords(journal)) as records:
        return account(Reading(records), period, LINE.cell)


def figures(made: Account) -> str:
    """Return all that a report says, but what it was made from."""
    plain = account_plain(made)
    for name in ('made_from', 'notes'):
        del plain[name]
    return json.dumps(plain, indent=1)


def first_seq(journal: Path) -> int:
    with closing(SqliteRecords(journal)) as records:
        return records.extent().first_seq


def has_open(pid: int, journal: Path) -> bool:
    with suppress(FileNotFoundError, PermissionError):
        return any(entry.resolve() == journal for entry in Path(f'/proc/{pid}/fd').iterdir())
    return True  # it has ended, and so has that moment


def cpu_ticks(pid: int) -> int:
    """Return how long a process has worked, in ticks of a hundredth of a second."""
    with suppress(FileNotFoundError, ProcessLookupError):
        fields = Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()
        return int(fields[11]) + int(fields[12])
    return 1 << 30


Moment = Callable[[int, Path], bool]


def worked(seconds: float) -> Moment:
    return lambda pid, _: cpu_ticks(pid) >= 100 * seconds


def has_ended(pid: int, _: Path) -> bool:
    """Its answer is there, and the node begins to write."""
    return cpu_ticks(pid) == 1 << 30


KILLS: list[tuple[str, Moment, str]] = [
    ('at its start', lambda *_: True, 'books'),
    ('at its start', lambda *_: True, 'both'),
    ('while it reads', has_open, 'node'),
    ('in the middle', worked(0.8), 'books'),
    ('in the middle', worked(1.0), 'both'),
    ('near its end', worked(1.3), 'node'),
    ('when it has answered', has_ended, 'node'),
    ('when events are removed', lambda _, journal: first_seq(journal) > 1, 'node'),
]
"""When, and who: the process that makes books, the node, or both at once."""


def kill(pid: int) -> None:
    with suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)


@pytest.mark.usefixtures('children_by_python')
@pytest.mark.long
def test_kills_while_making_books_leave_reports_unchanged(
    start_cell: StartCell, tmp_path: Path
) -> None:
    journal, every = tmp_path / 'cell.db', tmp_path / 'every event.db'
    make_long_journal(journal, EVENTS, quantity=40)
    shutil.copy(journal, every)
    period = Period.all_planned('the first slot', 0, 900_000_000)
    expected = figures(report(every, period))
    assert not report(every, period).books.span
    # Now: the node makes its books as soon as it runs.
    options = ['--journal', str(journal), '--journal-keep-jobs', '0']
    cell = start_cell(cell=LINE.text, run_options=options)
    child = cell.child(PROCESS)
    cell.connect()
    for name, moment, victims in KILLS:
        if first_seq(journal) == 1:
            child = cell.child(PROCESS)
        cell.watch.ros.spin_until(partial(moment, child, journal), f'books {name}')
        is_there = not has_ended(child, journal)
        if victims != 'node':
            kill(child)
        if victims == 'books' and is_there:
            cell.watch.ros.spin_until(lambda: TOLD in cell.node.errors, TOLD)
        assert cell.node.is_running
        cell.kill_and_restart_node()
        assert figures(report(journal, period)) == expected, (name, victims)
    cell.watch.ros.spin_until(lambda: first_seq(journal) > EVENTS - 100, 'the end of retention')
    made = report(journal, period)
    assert made.books.span
    assert figures(made) == expected
    cell.stop()
