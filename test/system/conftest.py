"""Fixtures of the system tests."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from cell_fixtures import (
    children_by_python,
    fast_discovery,
    loaded,
    small_cell,
    small_cell_file,
    start_cell,
)
from postgres_server import PostgresServer, postgres_server

__all__ = [
    'address',
    'children_by_python',
    'fast_discovery',
    'loaded',
    'server',
    'small_cell',
    'small_cell_file',
    'start_cell',
]


@pytest.fixture(scope='module')
def server() -> Iterator[PostgresServer]:
    """Give a database server for the tests of one file."""
    pytest.importorskip('psycopg', reason='needs psycopg: ./scripts/bootstrap --postgres')
    with postgres_server() as started:
        yield started


@pytest.fixture
def address(server: PostgresServer) -> str:
    """Give the address of a journal that does not exist yet."""
    return server.place(server.database(), 'small_cell')
