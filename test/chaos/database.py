"""The journal of a cell in PostgreSQL: a server, its replica, and a network that loses things."""

from __future__ import annotations

import signal
import tempfile
from collections.abc import Callable
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

from chaos.truth import Rows
from postgres_proxy import Proxy
from postgres_server import PostgresServer

CELL = 'chaos_cell'

EVERY_REPLICA = '*'

_SYNCHRONOUS = "SELECT count(*) = 1 FROM pg_stat_replication WHERE sync_state = 'sync'"
_STREAMING = "SELECT count(*) = 1 FROM pg_stat_replication WHERE state = 'streaming'"
_WAITING = "SELECT count(*) > 0 FROM pg_stat_activity WHERE wait_event = 'SyncRep'"


class Database:
    """A server and a replica, each behind a proxy of its own. Leaves nothing behind in `close`.

    :ivar server: the one that takes writes
    :ivar replica: it is synchronous, if it is to be
    """

    def __init__(self, *, synchronous: bool = True) -> None:
        self._open = ExitStack()
        self._proxies: list[Proxy] = []
        self._synchronous = synchronous
        try:
            self.server = self._kept(PostgresServer())
            self.server.start()
            self._name = self.server.database()
            if synchronous:
                self.server.wait_for_replicas(EVERY_REPLICA)
            self.make_replica()
            folders = [self._proxy(server) for server in (self.server, self.replica)]
        except BaseException:
            self.close()
            raise
        where = f'host={",".join(folders)}&target_session_attrs=read-write'
        self.address = f'postgresql://plant@/{self._name}/{CELL}?{where}'

    def close(self) -> None:
        """End everything."""
        self._open.close()

    def make_replica(self) -> None:
        """Make a replica of the server, and wait until it follows."""
        self.replica = self._kept(self.server.replica())
        self.server.until(_SYNCHRONOUS if self._synchronous else _STREAMING)

    def rows(self) -> Rows:
        """Return number and record of the events."""
        there = "SELECT 1 FROM pg_class WHERE oid = to_regclass('cell_1.events')"
        if not self.ask_all(there):
            return []
        query = 'SELECT seq, record FROM cell_1.events ORDER BY seq'
        return [(seq, record) for seq, record in self.ask_all(query)]

    def execute(self, statement: str) -> None:
        """Carry out a statement, as an administrator."""
        import psycopg

        with psycopg.connect(self.server.address(self._name), autocommit=True) as connection:
            connection.execute(statement.encode())

    def ask_all(self, query: str) -> list[Any]:
        """Return the rows of a query."""
        import psycopg

        with psycopg.connect(self.server.address(self._name), autocommit=True) as connection:
            return list(connection.execute(query.encode()))

    @property
    def is_waited_for(self) -> bool:
        """Tell whether a commit waits for the replica."""
        return bool(self.server.ask(_WAITING))

    def cancel_waits(self) -> None:
        """Let commits wait for the replica no longer, as an administrator may."""
        self.server.ask(
            'SELECT count(pg_cancel_backend(pid)) FROM pg_stat_activity '
            "WHERE wait_event = 'SyncRep'"
        )

    def replica_returns_alone(self) -> None:
        """End the server for good, and start the replica, which has nothing that came after it."""
        self.server.stop(signal.SIGQUIT)
        self.replica.start()

    # --- strikes ------------------------------------------------------------------------------

    def strike(self, how: str) -> Callable[[], bool]:
        """Do one of `plan.STRIKES`; return what tells whether it has happened."""
        if how in ('lost_answer', 'lost_commit'):
            return self._lose(how)
        {
            'cut': self._cut,
            'restart': lambda: self._restart(signal.SIGINT),
            'crash': lambda: self._restart(signal.SIGQUIT),
            'promotion': self._change_places,
        }[how]()
        return lambda: True

    def promote(self) -> None:
        """Let the replica take the place of the server, which is gone for good."""
        self.server.close()
        self.server = self.replica
        self.server.promote()

    def _change_places(self) -> None:
        self.promote()
        self.make_replica()
        free = next(proxy for proxy in self._proxies if proxy.server != self.server.folder)
        free.server = self.replica.folder

    def _cut(self) -> None:
        self.server.ask(
            'SELECT count(pg_terminate_backend(pid)) FROM pg_stat_activity '
            "WHERE application_name = 'bt_orchestrator node'"
        )

    def _restart(self, how: int) -> None:
        self.server.stop(how)
        self.server.start()

    def _lose(self, what: str) -> Callable[[], bool]:
        proxy = next(each for each in self._proxies if each.server == self.server.folder)
        event = proxy.loses_answer if what == 'lost_answer' else proxy.loses_commit
        event.set()
        return lambda: not event.is_set()

    def _kept(self, server: PostgresServer) -> PostgresServer:
        self._open.callback(server.close)
        return server

    def _proxy(self, server: PostgresServer) -> str:
        # Not in a folder of pytest: names of sockets are short.
        folder = self._open.enter_context(tempfile.TemporaryDirectory())
        self._proxies.append(self._open.enter_context(closing(Proxy(Path(folder), server.folder))))
        return folder
