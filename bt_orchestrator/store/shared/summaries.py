"""Summaries of jobs that ended, kept after their events are removed."""

from __future__ import annotations

import json
from collections.abc import Sequence

from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.jobs.job_record import JobRecord, job_from_plain, job_to_plain
from bt_orchestrator.model.records import Damage, JobPlace, Summaries
from bt_orchestrator.store.shared.database import Database, check_of, replace


def keep(database: Database, ended: Sequence[JobRecord]) -> None:
    """Write the summaries of jobs, replacing earlier ones."""
    texts = [(job.job, job.queued, json_of(job_to_plain(job))) for job in ended]
    rows = [(*row, check_of(0, row[-1].encode())) for row in texts]
    replace(database, 'jobs', 'job, queued', 'summary, checksum', rows)


def page(
    database: Database,
    after: JobPlace | None,
    most: int,
    *,
    newest_first: bool,
) -> Summaries:
    """Return the next jobs, as they were queued."""
    compare, order = ('<', 'DESC') if newest_first else ('>', 'ASC')
    name = 'CAST(job AS BLOB)'  # a damaged one may not be valid text
    where = '' if after is None else f'WHERE (queued, {name}) {compare} (?, ?)'
    values = () if after is None else (after.queued, after.job.encode(errors=_AS_IT_IS))
    query = (
        f'SELECT queued, {name}, CAST(summary AS BLOB), checksum FROM jobs {where} '
        f'ORDER BY queued {order}, {name} {order} LIMIT ?'
    )
    rows = database.execute(query, (*values, most + 1)).fetchall()
    jobs: list[JobRecord] = []
    damage: list[Damage] = []
    for _, job, text, checksum in rows[:most]:
        if checksum is None or checksum == check_of(0, text):
            jobs.append(job_from_plain(json.loads(text)))
        else:
            damage.append(
                Damage(f'the summary of job {job.decode(errors="replace")!r} is damaged')
            )
    rest = None
    if rows[most:]:
        queued, job = rows[most - 1][:2]
        rest = JobPlace(queued, job.decode(errors=_AS_IT_IS))
    return Summaries(jobs, damage, rest)


_AS_IT_IS = 'surrogateescape'
