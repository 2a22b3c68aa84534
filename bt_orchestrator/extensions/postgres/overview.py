"""The cells of a plant, and how each stands."""

from __future__ import annotations

from contextlib import closing

from bt_orchestrator.extensions.postgres.connecting import connected, place_of, speaking_of
from bt_orchestrator.extensions.postgres.schema import cells
from bt_orchestrator.ports.records import PlantCell

_SETTINGS = ('SET statement_timeout = 10000', 'SET default_transaction_read_only = on')

_QUERY = b"""\
SELECT o.cell, coalesce(o.state, ''), extract(epoch FROM o.state_since)::float8,
    coalesce(o.stop_reason, ''), coalesce(o.last_seq, 0),
    extract(epoch FROM o.last_event_at)::float8,
    greatest(extract(epoch FROM now() - o.complete_at), 0)::float8,
    (SELECT count(*) FROM plant.gaps g WHERE g.cell = o.cell), o.page
FROM plant.overview o ORDER BY o.cell"""


def cells_of(address: str) -> list[PlantCell]:
    """Return the cells of a plant, in the order of their names.

    :raises JournalUnusable: the database cannot be reached, or has none
    """
    place = place_of(address)
    with speaking_of(place), closing(connected(place, 'overview', _SETTINGS)) as connection:
        cells(connection)
        return [PlantCell(*row) for row in connection.execute(_QUERY)]


def journals_of(address: str) -> list[tuple[str, str]] | None:
    """Return each cell of a plant with the address of its tables; None: one cell is named.

    :raises JournalUnusable: the database cannot be reached, or has none
    """
    place = place_of(address)
    if place.cell:
        return None
    return [(cell.name, place.of(cell.name).whole) for cell in cells_of(address)]
