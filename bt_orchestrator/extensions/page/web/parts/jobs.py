"""Jobs as parts."""

from __future__ import annotations

import math

from bt_orchestrator.extensions.page.web.offers import back_for, job_offers
from bt_orchestrator.extensions.page.web.parts.tasks import TaskParts
from bt_orchestrator.model.codec import plain_but, to_plain
from bt_orchestrator.model.jobs.isa95 import OVER
from bt_orchestrator.model.jobs.made_anew import MadeAnew
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.status import CellStatus, JobStatus
from bt_orchestrator.ports.doors.known import Ordered

NOT_KNOWN = Ordered({}, None)
"""The order of a job that was given before anybody listened."""


def job_part(
    job: JobStatus,
    status: CellStatus,
    script: Script | None,
    tasks: TaskParts,
    ordered: Ordered,
) -> dict[str, object]:
    """Return a job with its initialization tasks.

    :param script: its script, if that is known
    """
    listed = tasks.of_initialization(job, script, status.initialization) if script else []
    return {
        **plain_but(job, *_LEFT_OUT),
        'anew': _anew(job.anew),
        'state': job.state.state,
        'substate': job.state.substate,
        'is_over': job.state in OVER,
        'left': job.left,
        'on_line': job.on_line,
        'ends': _ends(job, status),
        'late_s': _late_s(job, status),
        'is_overdue': job.state not in OVER and job.due is not None and status.stamp > job.due,
        'tasks': listed,
        'params': to_plain(ordered.params),
        'choice': to_plain(ordered.choice, whole=True),
        'changed_by': [*job.unavailable, *back_for(job, status)],
        'offers': job_offers(job, status),
    }


_LEFT_OUT = (
    'by_recipe',
    'expected_end_s',
    'queued_at',
    'started_at',
    'ended_at',
    'running',
    'passed',
)
"""Fields that the page reads elsewhere, or never: an equal part is not sent again."""


def _anew(anew: MadeAnew | None) -> dict[str, object] | None:
    """Return why it was made anew, and the pace since; None: it was not."""
    return None if anew is None else {**plain_but(anew), 'slower': anew.slower}


def _ends(job: JobStatus, status: CellStatus) -> float | None:
    """Return when it is expected to end, in whole seconds: rounding alone does not change it."""
    if job.expected_end_s is None:
        return None
    return float(round(status.stamp + job.expected_end_s))


def _late_s(job: JobStatus, status: CellStatus) -> float:
    """Return by how much it misses its due time as it looks now, in whole minutes begun."""
    if job.due is None or job.state in OVER:
        return 0.0
    late_s = max(_ends(job, status) or 0.0, status.stamp) - job.due
    return max(0.0, math.ceil(late_s / 60) * 60.0)
