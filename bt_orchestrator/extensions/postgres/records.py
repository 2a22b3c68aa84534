"""Reading the journal of a cell in a database, with or without a running orchestrator."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from bt_orchestrator.extensions.postgres.connecting import connected, place_of, speaking_of
from bt_orchestrator.extensions.postgres.journal import mark_place
from bt_orchestrator.extensions.postgres.schema import cell_named, check_of_row, stretches
from bt_orchestrator.extensions.postgres.session import Session
from bt_orchestrator.store.shared.looking import Terms
from bt_orchestrator.store.shared.mark import Reached, mark_of, read_mark
from bt_orchestrator.store.shared.records import KeptRecords

WITHIN_S = 30.0
"""Longest wait for the answer to one query."""

_SETTINGS = (f'SET statement_timeout = {int(WITHIN_S * 1000)}',)


class PostgresRecords(KeptRecords):
    """The tables of a cell, read-only and without its lock. Implements `ports.Records`."""

    _terms = Terms(
        'job = ?',
        'time >= ?',
        'time <= ?',
        r"event LIKE replace(replace(?, '_', '\_'), '*', '%')",
        check=check_of_row,
    )

    def __init__(self, address: str, marks: Path | None = None) -> None:
        """Open the journal of a cell.

        :param marks: folder of this machine's marks; None: the usual one
        :raises JournalUnusable: it is not there, or newer
        """
        self._place = place_of(address)
        self._name = str(self._place)
        self._mark = mark_of(mark_place(self._place, marks))
        self._session = self._opened()

    def _opened(self) -> Session:
        connection = connected(self._place, 'reader', _SETTINGS)
        try:
            with speaking_of(self._place):
                cell = cell_named(connection, self._place)
                tables = stretches(connection, cell)[-1].tables
                connection.execute(f'SET search_path = {tables}'.encode())
        except BaseException:
            connection.close()
            raise
        return Session(connection, WITHIN_S)

    def close(self) -> None:
        """Close the connection."""
        self._session.close()

    def _reached(self) -> Reached | None:
        return read_mark(self._mark)

    @contextmanager
    def _one_moment(self) -> Iterator[Session]:
        if self._session.is_broken:
            self._session.close()
            self._session = self._opened()
        session = self._session
        with speaking_of(self._place):
            session.ask('BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY')
            try:
                yield session
            finally:
                if not session.is_broken:
                    session.ask('ROLLBACK')


def open_records(address: str) -> PostgresRecords:
    """Open the journal of a cell for reading.

    :raises JournalUnusable: it cannot be read
    """
    return PostgresRecords(address)
