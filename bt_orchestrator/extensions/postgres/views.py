"""The views of `plant`: the tables of all cells as one, and what they say in columns."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from psycopg import sql


class View(NamedTuple):
    """A view of `plant`."""

    name: str
    part: str
    """SELECT of one stretch `s` of a cell; they are put together with UNION ALL."""
    whole: str = 'SELECT * FROM ({parts}) AS parts'
    since: int = 1
    """Version of the tables of a stretch from which on they have what it shows."""


def _part(columns: str, table: str) -> str:
    return (
        f'SELECT {{cell}}::text AS cell, s.history, {columns} FROM plant.stretches s, '
        f'{{tables}}.{table} WHERE s.number = {{number}}'
    )


_IS_CURRENT = 's.history = (SELECT c.history FROM plant.cells c WHERE c.number = s.cell)'
"""Whether a row is of the history that the cell has now."""

_BOOKS = f' AND {_IS_CURRENT}'
"""The account is that of one history: an older one may cover the same time."""

VIEWS = (
    View(
        'histories',
        f"""SELECT {{cell}}::text AS cell, s.history, p.history AS parent, s.first_seq,
               {_IS_CURRENT} AS is_current
           FROM plant.stretches s LEFT JOIN plant.stretches p ON p.number = s.parent
           WHERE s.number = {{number}}""",
    ),
    View(
        'events',
        _part(
            'e.seq, to_timestamp(e.time) AS at, e.time, e.event, e.job, e.record, '
            'plant.fact(e.record) AS fact',
            'events e',
        ),
    ),
    View('gaps', _part('g.first_seq, g.last_seq, g.why, g.noticed', 'gaps g')),
    # A job that two histories know is told by the newer one.
    View(
        'jobs',
        _part('s.number, j.job, j.queued, j.summary', 'jobs j'),
        """SELECT cell, history, job, to_timestamp(queued) AS queued_at,
               fact ->> 'script' AS script, (fact ->> 'quantity')::bigint AS quantity,
               fact ->> 'status' AS status,
               to_timestamp((fact ->> 'started')::double precision) AS started_at,
               to_timestamp((fact ->> 'ended')::double precision) AS ended_at,
               packed, rejected, missing, nonconforming,
               greatest(packed - nonconforming, 0) AS good,
               packed + rejected + by_hand AS produced, summary
           FROM (SELECT DISTINCT ON (cell, job, queued) *, plant.fact(summary) AS fact
               FROM ({parts}) AS parts ORDER BY cell, job, queued, number DESC) AS jobs,
           LATERAL (SELECT
               coalesce((fact -> 'counts' ->> 'packed')::bigint, 0) AS packed,
               coalesce((fact -> 'counts' ->> 'rejected')::bigint, 0) AS rejected,
               coalesce((fact -> 'counts' ->> 'missing')::bigint, 0) AS missing,
               coalesce((fact -> 'counts' ->> 'nonconforming')::bigint, 0) AS nonconforming,
               coalesce((fact -> 'counts' ->> 'by_hand')::bigint, 0) AS by_hand) AS counts""",
    ),
    View('snapshots', _part('n.seq, n.stamp, n.state', 'snapshots n')),
    View('beginnings', _part('b.seq, b.stamp, b.state', 'beginning b')),
    View(
        'books',
        _part(
            'to_timestamp(b.begin_us / 1e6) AS begin_at, to_timestamp(b.until_us / 1e6) AS '
            'until_at, b.made_of, b.version, plant.fact(b.slot) AS slot',
            'book_slots b',
        )
        + _BOOKS,
    ),
    View(
        'book_states',
        _part(
            'b.seq, to_timestamp(b.now_us / 1e6) AS at, b.made_of, b.version, b.state',
            'book_states b',
        )
        + _BOOKS,
    ),
    View('book_scripts', _part('b.digest, b.script', 'book_scripts b') + _BOOKS),
    View(
        'book_reasons',
        _part('b.made_of, plant.fact(b.reason) AS reason', 'book_reasons b') + _BOOKS,
        since=2,
    ),
    View('used_ids', _part('u.digest, u.copy, u.ids', 'used_ids u')),
    # How each cell stands, as far as its events are here.
    View(
        'overview',
        f"""SELECT {{cell}}::text AS cell, c.kept_by, c.page, c.history, c.complete_at,
               plant.fact(t.record) ->> 'state' AS state, to_timestamp(t.time) AS state_since,
               plant.fact(r.record) ->> 'stop_reason' AS stop_reason,
               e.seq AS last_seq, to_timestamp(e.time) AS last_event_at
           FROM plant.stretches s JOIN plant.cells c ON c.number = s.cell
           LEFT JOIN LATERAL (SELECT e.record, e.time FROM {{tables}}.events e
               WHERE e.event = 'cell.state_changed' ORDER BY e.time DESC LIMIT 1) t ON true
           LEFT JOIN LATERAL (SELECT e.record FROM {{tables}}.events e
               WHERE e.event = 'cell.stop_reason_changed' ORDER BY e.time DESC LIMIT 1) r ON true
           LEFT JOIN LATERAL (SELECT e.seq, e.time FROM {{tables}}.events e
               ORDER BY e.seq DESC LIMIT 1) e ON true
           WHERE s.number = {{number}} AND {_IS_CURRENT}""",
    ),
)


def view_statements(stretches: Sequence[tuple[int, str, str, int]]) -> Iterator[sql.Composed]:
    """Yield what makes the views of some stretches.

    :param stretches: the number of each, the name of its cell, and the schema of its tables with
        their version; programs bring those of their own cells up to date
    """
    for view in VIEWS:
        if all(version < view.since for *_, version in stretches):
            continue
        parts = sql.SQL(' UNION ALL ').join(
            sql.SQL('({})').format(
                sql.SQL(view.part).format(
                    number=sql.Literal(number),
                    cell=sql.Literal(cell),
                    tables=sql.Identifier(tables),
                )
            )
            for number, cell, tables, version in stretches
            if version >= view.since
        )
        whole = sql.SQL(view.whole).format(parts=parts)
        yield sql.SQL('CREATE OR REPLACE VIEW plant.{} AS {}').format(
            sql.Identifier(view.name), whole
        )
