"""Addresses of a plant's database, and connections to it."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple, TypeAlias
from urllib.parse import quote, unquote

import psycopg
from psycopg.conninfo import conninfo_to_dict, make_conninfo

from bt_orchestrator.base.errors import DatabaseAway, JournalUnusable

EXAMPLE = 'postgresql://USER@HOST/DATABASE/CELL'

CONNECT_S = 5
"""Longest time to wait for a server."""

_LIVELY = {
    'connect_timeout': CONNECT_S,
    'keepalives_idle': 5,
    'keepalives_interval': 2,
    'keepalives_count': 3,
    'tcp_user_timeout': 10_000,
}
"""A server that vanished is noticed within about ten seconds; an address may say otherwise."""

Connection: TypeAlias = 'psycopg.Connection[Any]'


class Place(NamedTuple):
    """A plant's database, and a cell in it."""

    address: str
    """For libpq, without the cell."""
    cell: str
    """Empty: all cells."""

    def __str__(self) -> str:
        """Return the address as it may be shown: without password and options."""
        shown = _shown(self.address)
        return f'{shown}/{self.cell}' if self.cell else shown

    @property
    def whole(self) -> str:
        """The address with the cell, as `place_of` reads it."""
        address, mark, options = self.address.partition('?')
        return f'{address}/{quote(self.cell, safe="")}{mark}{options}'

    def of(self, cell: str) -> Place:
        """Return the place of a cell of the same database."""
        return self._replace(cell=cell)


_FORM = re.compile(r'(postgres(?:ql)?://[^/?#]*/[^/?#]+)(?:/([^/?#]*))?(\?[^#]*)?')


def place_of(address: str) -> Place:
    """Return the place that an address names.

    :raises JournalUnusable: it is no address of a plant's database
    """
    match = _FORM.fullmatch(address)
    try:
        if match is None:
            raise ValueError(f'found {_shown(address)}')
        place = Place(match[1] + (match[3] or ''), unquote(match[2] or ''))
        conninfo_to_dict(place.address)
    except (ValueError, psycopg.ProgrammingError) as error:
        what = f"expected the address of a plant's database, {EXAMPLE}: {error}"
        raise JournalUnusable(what) from error
    return place


def connected(
    place: Place, what: str, settings: Sequence[str] = (), connect_s: float = CONNECT_S
) -> Connection:
    """Connect to a database; each statement is a transaction of its own.

    :param what: name of the program for the server's lists of connections
    :param settings: statements `SET …` that begin the session
    :param connect_s: longest time to wait for each server of the address, two seconds at least
    :raises DatabaseAway: it cannot be reached
    """
    with speaking_of(place):
        within = {'connect_timeout': max(2, min(int(connect_s), CONNECT_S))}
        options = {**_LIVELY, **within, **conninfo_to_dict(place.address)}
        connection = psycopg.connect(
            make_conninfo('', **options),
            autocommit=True,
            client_encoding='UTF8',
            application_name=f'bt_orchestrator {what}'[:63],
        )
        try:
            for setting in settings:
                connection.execute(setting.encode())
        except BaseException:
            connection.close()
            raise
    return connection


@contextmanager
def speaking_of(place: Place) -> Iterator[None]:
    """Convert errors of PostgreSQL to one that names the database and says what to do.

    :raises DatabaseAway: there is no connection any more, or none was made
    :raises JournalUnusable: the database refuses what was asked
    """
    try:
        yield
    except (psycopg.OperationalError, psycopg.InterfaceError) as error:
        raise DatabaseAway(
            f"the plant's database {place} cannot be reached: {_words(error)}; check address, "
            'server and rights'
        ) from error
    except psycopg.errors.InsufficientPrivilege as error:
        raise JournalUnusable(
            f"the plant's database {place} refuses it: {_words(error)}; use a role with the "
            'rights, see docs/plant.md'
        ) from error
    except psycopg.Error as error:
        raise JournalUnusable(
            f"the plant's database {place} cannot be used: {_words(error)}"
        ) from error


def _words(error: Exception) -> str:
    return ' '.join(str(error).split())


def _shown(address: str) -> str:
    return re.sub(r'(//[^/?:@]*):[^/?@]*@', r'\1@', address).partition('?')[0]
