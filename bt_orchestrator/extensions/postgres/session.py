"""A connection that never waits longer than it may, and says when the server has answered all."""

from __future__ import annotations

import math
import re
import select
import threading
import time
from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from typing import Any

import psycopg
from psycopg import pq
from psycopg.adapt import Transformer

from bt_orchestrator.extensions.postgres.connecting import Connection

BYTEA = 17
"""Type of bytes, by its number in the catalogue."""


class Late(psycopg.OperationalError):  # type: ignore[misc]
    """The server has not answered in time; what was asked of it may have been done or not."""


class NotOnReplicas(psycopg.OperationalError):  # type: ignore[misc]
    """A commit is on this server alone: somebody cancelled its wait for the replicas."""


class Session:
    """A connection with a deadline. Implements `store.shared.database.Database`.

    An answer is complete when the server is ready for the next query, not when it has carried out
    a statement: the commit comes after that, and so does the wait for the replicas.
    """

    Error = psycopg.Error

    def __init__(self, connection: Connection, within_s: float) -> None:
        """Begin.

        :param within_s: longest time to wait for an answer, unless `until` says less
        """
        self._connection = connection
        self._transformer = Transformer(connection)
        self._one_at_a_time = threading.RLock()
        self._kept: dict[str, bytes] = {}
        self._warned = ''
        self.within_s = within_s
        self.until = math.inf
        """When any answer is too late, by the steady clock."""
        self._deadline = 0.0
        self.backend = connection.pgconn.backend_pid
        """The process of the server that serves it."""
        connection.add_notice_handler(self._notice)

    @property
    def is_broken(self) -> bool:
        """Tell whether nothing can be asked any more."""
        return bool(self._connection.pgconn.status != pq.ConnStatus.OK)

    def execute(self, query: str, values: Sequence[Any] = (), /) -> Rows:
        """Carry out a statement of SQL that SQLite knows as well, and return its rows.

        :raises Late: no answer came in time; the connection is of no use any more
        :raises NotOnReplicas: it is committed, and lost if this server is
        :raises psycopg.Error: it failed
        """
        return self.ask(in_postgres(query), values)

    def executemany(self, query: str, rows: Iterable[Sequence[Any]], /) -> None:
        """Carry out a statement once for each row of values."""
        for row in rows:
            self.execute(query, row)

    def ask(self, query: str, values: Sequence[Any] = (), *, often: bool = False) -> Rows:
        """Carry out a statement of PostgreSQL, with `$1` for the first value.

        :param often: it comes again and again: the server reads it and plans it once
        """
        given = [_given(value) for value in values]
        kinds = [BYTEA if isinstance(value, bytes) else 0 for value in values]
        formats = [int(kind == BYTEA) for kind in kinds]
        with self._one_at_a_time:
            self._warned = ''
            self._deadline = min(self.until, time.monotonic() + self.within_s)
            pgconn = self._connection.pgconn
            if not often:
                pgconn.send_query_params(query.encode(), given, kinds, formats)
                return self._answer(pgconn)
            if query not in self._kept:
                name = f'kept_{len(self._kept)}'.encode()
                pgconn.send_prepare(name, query.encode(), kinds)
                self._answer(pgconn)
                self._kept[query] = name
            pgconn.send_query_prepared(self._kept[query], given, formats)
            return self._answer(pgconn)

    def close(self) -> None:
        """Close it, after the answer that another thread waits for."""
        with self._one_at_a_time:
            self._connection.close()

    def _answer(self, pgconn: pq.abc.PGconn) -> Rows:
        """Return the rows that were asked for, when the server is ready for the next query."""
        results = list(self._results(pgconn))
        if self._warned:
            raise NotOnReplicas(self._warned)
        for result in results:
            if result.status not in (pq.ExecStatus.TUPLES_OK, pq.ExecStatus.COMMAND_OK):
                raise psycopg.errors.error_from_result(result)
        return Rows(self._transformer, results[-1])

    def _results(self, pgconn: pq.abc.PGconn) -> Iterator[pq.abc.PGresult]:
        """Yield results until the server is ready for the next query."""
        while pgconn.flush():
            self._wait(pgconn, select.POLLIN | select.POLLOUT)
            pgconn.consume_input()
        while True:
            while pgconn.is_busy():
                self._wait(pgconn, select.POLLIN)
                pgconn.consume_input()
            result = pgconn.get_result()
            if result is None:
                return
            yield result

    def _wait(self, pgconn: pq.abc.PGconn, events: int) -> None:
        left_s = self._deadline - time.monotonic()
        poll = select.poll()
        poll.register(pgconn.socket, events)
        if left_s <= 0 or not poll.poll(left_s * 1000):
            self.close()
            raise Late('the server has not answered in time')

    def _notice(self, notice: psycopg.errors.Diagnostic) -> None:
        # 01000 is "warning": the server says so of a wait for replicas that was cancelled.
        if notice.sqlstate == '01000':
            self._warned = str(notice.message_primary)


class Rows:
    """The rows that a statement found."""

    def __init__(self, transformer: Transformer, result: pq.abc.PGresult) -> None:
        self.changed = result.command_tuples or 0
        """How many rows it wrote."""
        self.words = (result.command_status or b'').decode()
        """The answer of the server in words, as `COMMIT`."""
        transformer.set_pgresult(result)
        self._rows: Iterator[Any] = iter(transformer.load_rows(0, result.ntuples, tuple))

    def __iter__(self) -> Iterator[Any]:
        return self._rows

    def fetchone(self) -> Any:
        """Return the next row; None: there is none."""
        return next(self._rows, None)

    def fetchall(self) -> list[Any]:
        """Return all other rows."""
        return list(self._rows)

    def close(self) -> None:
        """Do nothing: all rows are here."""


@lru_cache(maxsize=256)
def in_postgres(query: str) -> str:
    """Return a statement of SQLite's SQL as PostgreSQL says it."""
    query = re.sub(r'CAST\((\w+) AS BLOB\)', r"convert_to(\1, 'UTF8')", query)
    first, *others = query.split('?')
    return first + ''.join(f'${number}{part}' for number, part in enumerate(others, 1))


def array_of(values: Iterable[str | float | None]) -> str:
    """Return an array as PostgreSQL reads it."""
    return f'{{{",".join(map(_element, values))}}}'


def _element(value: str | float | None) -> str:
    if isinstance(value, str):
        escaped = value.replace('\\', '\\\\').replace('"', '\\"')
        return f'"{escaped}"'
    return 'NULL' if value is None else repr(value)


def _given(value: object) -> bytes | None:
    if value is None or isinstance(value, bytes):
        return value
    return str(int(value) if isinstance(value, bool) else value).encode(errors='surrogateescape')
