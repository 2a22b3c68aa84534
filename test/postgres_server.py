"""A PostgreSQL server of a test: its own cluster in a temporary folder, not as root."""

from __future__ import annotations

import json
import os
import pwd
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from itertools import count
from pathlib import Path
from typing import Any

from patience import PATIENCE_S

from bt_orchestrator.model.codec import from_record
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.keeping.records import Wanted

USER = 'plant'
"""Owns every database."""

REPLICA = 'replica'
"""The name of each replica at its server."""

_FAST = {
    'listen_addresses': '',
    'max_connections': '40',
    'max_wal_size': '64MB',
    'shared_buffers': '16MB',
    'fsync': 'off',
    'synchronous_commit': 'on',
    'log_min_messages': 'fatal',
    'wal_retrieve_retry_interval': '100ms',
}


def program(name: str) -> str:
    """Return the path of a program of the server; empty: there is none."""
    folders = sorted(
        Path('/usr/lib/postgresql').glob(f'*/bin/{name}'), key=lambda p: int(p.parts[-3])
    )
    return str(folders[-1]) if folders else shutil.which(name) or ''


class PostgresServer:
    """A server on a socket in its folder, which may be stopped, killed and started again."""

    def __init__(
        self, of: PostgresServer | None = None, disk: str | None = None, **settings: str
    ) -> None:
        """Make one, which does not run yet.

        :param of: the server that it is a replica of, under the name `REPLICA`; None: its own
        :param disk: where its folder is, by a short name, since a socket is in it; None: where all
            temporary files are
        """
        self.folder = Path(tempfile.mkdtemp(prefix='pg', dir=disk))
        self._as: dict[str, Any] = {}
        if os.geteuid() == 0:
            who = _somebody()
            os.chown(self.folder, who.pw_uid, who.pw_gid)
            self._as = {'user': who.pw_uid, 'group': who.pw_gid, 'extra_groups': []}
        self._settings = {
            **_FAST,
            'unix_socket_directories': str(self.folder),
            **settings,
        }
        self._process: subprocess.Popen[bytes] | None = None
        self._names = count(1)
        data = self.folder / 'data'
        if of is None:
            self._run(
                *('initdb', '--no-sync', '--auth=trust', '--encoding=UTF8', '--locale=C'),
                *(f'--username={USER}', f'--pgdata={data}'),
            )
            return
        at = f'host={of.folder} user={USER}'
        self._settings['primary_conninfo'] = f'{at} application_name={REPLICA}'
        self._run('pg_basebackup', '--no-sync', '--checkpoint=fast', '-d', at, '-D', str(data))
        self._run('touch', str(data / 'standby.signal'))

    def start(self) -> None:
        """Start it, and wait until it answers."""
        options = [f'--{name}={value}' for name, value in self._settings.items()]
        log = (self.folder / 'log').open('ab')
        with log:
            self._process = subprocess.Popen(
                [program('postgres'), '-D', str(self.folder / 'data'), *options],
                cwd='/',
                stdout=log,
                stderr=log,
                **self._as,
            )
        import psycopg

        deadline = time.monotonic() + PATIENCE_S
        while True:
            try:
                psycopg.connect(self.address('postgres')).close()
            except psycopg.OperationalError:
                if time.monotonic() > deadline or self._process.poll() is not None:
                    raise
                time.sleep(0.02)
            else:
                return

    def replica(self) -> PostgresServer:
        """Make a replica of it, and start it."""
        made = PostgresServer(self)
        made.start()
        return made

    def promote(self) -> None:
        """Make a replica a server that takes writes."""
        self.ask('SELECT pg_promote(true, 60)')

    def wait_for_replicas(self, names: str) -> None:
        """Let each commit wait for replicas.

        :param names: as in `synchronous_standby_names`; empty: for none
        """
        self.ask(f"ALTER SYSTEM SET synchronous_standby_names = '{names}'")
        self.ask('SELECT pg_reload_conf()')
        self.until(f"SELECT current_setting('synchronous_standby_names') = '{names}'")

    def ask(self, query: str) -> Any:
        """Return the first value that a query gives; it waits for no replica."""
        import psycopg

        with psycopg.connect(self.address('postgres'), autocommit=True) as connection:
            connection.execute('SET synchronous_commit = local')
            answer = connection.execute(query.encode())
            return answer.fetchone()[0] if answer.description else None

    def until(self, query: str) -> None:
        """Wait until a query says yes."""
        deadline = time.monotonic() + PATIENCE_S
        while not self.ask(query):
            assert time.monotonic() < deadline, query
            time.sleep(0.02)

    def stop(self, how: int = signal.SIGINT) -> None:
        """End it: SIGINT ends connections, SIGQUIT ends at once as after a crash."""
        if self._process is not None:
            self._process.send_signal(how)
            self._process.wait(PATIENCE_S)
            self._process = None

    def close(self) -> None:
        """End it, and remove its folder."""
        self.stop(signal.SIGQUIT)
        shutil.rmtree(self.folder, ignore_errors=True)

    def address(self, database: str) -> str:
        return f'postgresql://{USER}@/{database}?host={self.folder}'

    def place(self, database: str, cell: str) -> str:
        """Return the address of a cell."""
        return f'postgresql://{USER}@/{database}/{cell}?host={self.folder}'

    def database(self) -> str:
        """Make a new database and return its name."""
        import psycopg

        name = f'plant_{next(self._names)}'
        with psycopg.connect(self.address('postgres'), autocommit=True) as connection:
            connection.execute(f'CREATE DATABASE {name}'.encode())
        return name

    def _run(self, name: str, *words: str) -> None:
        path = program(name) or shutil.which(name)
        assert path, 'needs a PostgreSQL server: ./scripts/bootstrap --postgres'
        subprocess.run([path, *words], cwd='/', check=True, capture_output=True, **self._as)


def _somebody() -> pwd.struct_passwd:
    """Return a user without rights: the server refuses to run as root."""
    for name in ('postgres', 'nobody'):
        try:
            return pwd.getpwnam(name)
        except KeyError:
            continue
    raise AssertionError('expected a user postgres or nobody; the server does not run as root')


@contextmanager
def postgres_server(**settings: str) -> Iterator[PostgresServer]:
    """Give a running server."""
    server = PostgresServer(None, None, **settings)
    try:
        server.start()
        yield server
    finally:
        server.close()


def kept_events(address: str) -> list[Event]:
    """Return the events of a journal, which has no damage."""
    from bt_orchestrator.extensions.postgres.records import PostgresRecords

    with closing(PostgresRecords(address)) as records:
        page = records.page(Wanted())
    assert page.is_last
    assert not page.damage
    return [from_record(json.loads(record.text)) for record in page.records]
