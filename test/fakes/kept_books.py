"""Books of a journal file, made in the process of the test."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import closing
from pathlib import Path

from bt_orchestrator.engine.runtime.writers import WritesAtOnce, Written
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.keeping.books import Books
from bt_orchestrator.store.sqlite.records import SqliteRecords
from bt_orchestrator.store.sqlite.store import SqliteStore
from bt_orchestrator.view.report.account.bookkeeper import next_books
from bt_orchestrator.view.report.account.course import Course
from bt_orchestrator.view.report.account.fold import AccountFold, Begun, FromBooks
from bt_orchestrator.view.report.account.planned import Planned
from bt_orchestrator.view.report.account.steady_time import SteadyTime
from bt_orchestrator.view.report.account.total import Total
from bt_orchestrator.view.report.line_stops import GivenReasons


def _no_damage(sentence: str) -> None:
    raise AssertionError(sentence)


def make_books(path: Path, most: int = 100_000, tell: Callable[[str], None] = _no_damage) -> Books:
    """Return the next books of a journal file, as they come from another process."""
    with closing(SqliteRecords(path)) as records:
        return Books.from_bytes(next_books(records, tell, most).to_bytes())


def book_all(
    store: SqliteStore,
    path: Path,
    most: int = 100_000,
    tell: Callable[[str], None] = _no_damage,
) -> int:
    """Bring the books of a journal up to date; returns the number of steps that it took."""
    for step in range(1, 1000):
        made = make_books(path, most, tell)
        store.keep_books(made)
        if made.is_last:
            return step
    raise AssertionError('it does not come to an end')


class BooksAtOnce:
    """Makes books while the caller waits. Implements `ports.Bookkeeping`."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.begun = 0

    def begin(self) -> Written[Books]:
        """Make them."""
        self.begun += 1
        return WritesAtOnce().begin(lambda: make_books(self._path))

    def close(self) -> None:
        """Do nothing: it works only when it is asked."""


def whole_fold(planned: Planned, events: Iterable[Event]) -> AccountFold:
    """Return a fold without books, which knows the reasons of stops that some events tell."""
    begin, reasons = planned.pieces[0][0], GivenReasons()
    for event in events:
        reasons.follow(event)
    course, total = Course(is_whole=True, begin=begin), Total(reasons)
    begun = Begun(course, total, begin, None, FromBooks(), lambda _: None, SteadyTime())
    return AccountFold(planned, begun=begun)
