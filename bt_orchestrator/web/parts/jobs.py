"""Jobs as parts."""

from __future__ import annotations

from bt_orchestrator.doors.known import Ordered
from bt_orchestrator.model.codec import to_plain
from bt_orchestrator.model.jobs.isa95 import OVER
from bt_orchestrator.model.jobs.made_anew import MadeAnew
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.status import CellStatus, JobStatus
from bt_orchestrator.web.offers import job_offers
from bt_orchestrator.web.parts.tasks import TaskParts

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
        'id': job.id,
        'script': job.script,
        'recipe': job.recipe,
        'recipe_version': job.recipe_version,
        'rest_of': job.rest_of,
        'anew': _anew(job.anew),
        'digest': job.digest,
        'state': job.state.state,
        'substate': job.state.substate,
        'is_over': job.state in OVER,
        'position': job.position,
        'ending': job.ending,
        'quantity': job.quantity,
        'started': job.started,
        'placed': job.placed,
        'processed': job.processed,
        'packed': job.packed,
        'good': job.good,
        'by_hand': job.by_hand,
        'rejected': job.rejected,
        'nonconforming': job.nonconforming,
        'missing': job.missing,
        'left': job.left,
        'on_line': job.on_line,
        'priority': job.priority,
        'start': job.start,
        'awaits_start': job.awaits_start,
        'awaits_release': job.awaits_release,
        'held': job.held,
        'unavailable': list(job.unavailable),
        'due': job.due,
        'ends': _ends(job, status),
        'end_unknown': job.end_unknown,
        'initialization': list(job.initialization),
        'tasks': listed,
        'params': to_plain(ordered.params),
        'choice': to_plain(ordered.choice, whole=True),
        'offers': job_offers(job, status),
    }


def _anew(anew: MadeAnew | None) -> dict[str, object] | None:
    """Return why it was made anew, and the pace since; None: it was not."""
    return None if anew is None else {**to_plain(anew, whole=True), 'slower': anew.slower}


def _ends(job: JobStatus, status: CellStatus) -> float | None:
    """Return when it is expected to end, in whole seconds: rounding alone does not change it."""
    if job.expected_end_s is None:
        return None
    return float(round(status.stamp + job.expected_end_s))
