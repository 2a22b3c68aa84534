"""Books made in another process: they come, or the node is told why not."""

from __future__ import annotations

import os
from contextlib import closing
from pathlib import Path

import pytest
from fakes.long_journal import make_long_journal

from bt_orchestrator.base.child_process import ChildFailed
from bt_orchestrator.cli.processes.bookkeeping_process import BooksProcess
from bt_orchestrator.store.sqlite.store import SqliteStore

LONGEST_S = 40.0


def test_process_books_journal_open_in_node(tmp_path: Path) -> None:
    path = tmp_path / 'journal'
    seq = make_long_journal(path, 100, quantity=3)
    with closing(SqliteStore(path)) as store, closing(BooksProcess(path)) as process:
        making = process.begin()
        assert making.has_ended(LONGEST_S)
        made = making.result()
        store.keep_books(made)
        assert (made.reached, made.is_last, store.booked()) == (seq, True, seq)
        child = process._process
        assert child is not None
        assert child.pid is not None
        with pytest.raises(ProcessLookupError):
            os.kill(child.pid, 0)


def test_why_there_are_no_books_is_told(tmp_path: Path) -> None:
    with closing(BooksProcess(tmp_path / 'none')) as process:
        making = process.begin()
        assert making.has_ended(LONGEST_S)
        with pytest.raises(ChildFailed, match='there is no journal'):
            making.result()


def test_an_end_of_the_node_ends_the_process(tmp_path: Path) -> None:
    path = tmp_path / 'journal'
    make_long_journal(path, 100, quantity=3)
    process = BooksProcess(path)
    making = process.begin()
    process.close()
    assert making.has_ended(LONGEST_S)
    with pytest.raises(ChildFailed):
        making.result()
