"""A PostgreSQL server for these tests, and a new database for each."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

pytest.importorskip('psycopg', reason='needs psycopg: ./scripts/bootstrap --postgres')

from postgres_server import PostgresServer, postgres_server

from bt_orchestrator.extensions.postgres.connecting import Connection, Place, connected, place_of


@pytest.fixture(scope='session')
def server() -> Iterator[PostgresServer]:
    with postgres_server() as instance:
        yield instance


@pytest.fixture
def place(server: PostgresServer) -> Place:
    """Give the place of a cell in a new database."""
    return place_of(server.place(server.database(), 'line_1'))


@pytest.fixture
def connection(place: Place) -> Iterator[Connection]:
    with connected(place, 'test') as session:
        yield session
