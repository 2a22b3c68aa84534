"""A status as parts, by the keys under which the page knows them; jobs, sections, the belt."""

from __future__ import annotations

import math
from collections.abc import Mapping

from bt_orchestrator.extensions.page.web.offers import (
    add_offer,
    back_for,
    cell_offers,
    component_offers,
    hold_offers,
    item_offers,
    job_offers,
    manual_offers,
)
from bt_orchestrator.extensions.page.web.parts.tasks import Part, TaskParts, wait_parts, why_part
from bt_orchestrator.extensions.page.web.wording import said_in_each
from bt_orchestrator.model.by import named
from bt_orchestrator.model.codec import plain_but, to_plain
from bt_orchestrator.model.frozen import changed
from bt_orchestrator.model.hold_words import hold_words
from bt_orchestrator.model.jobs.isa95 import OVER
from bt_orchestrator.model.jobs.order import MadeAnew
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.state import Hold
from bt_orchestrator.model.status import (
    CellDescription,
    CellStatus,
    ComponentDescription,
    ComponentStatus,
    JobStatus,
    Leadership,
    SectionStatus,
)
from bt_orchestrator.model.status_words import component_trouble, task_label
from bt_orchestrator.model.stop_reason import StopReason, Wish
from bt_orchestrator.model.wait import StandCause
from bt_orchestrator.ports.doors.known import Ordered

WORKING, QUIET, STOPPED, TROUBLE = 'working', 'quiet', 'stopped', 'trouble'
"""Kinds of states: how a page shows one, before anybody has read its word."""

_QUIET = frozenset(
    (
        PackmlState.RESETTING,
        PackmlState.IDLE,
        PackmlState.COMPLETING,
        PackmlState.COMPLETE,
        PackmlState.SUSPENDING,
        PackmlState.SUSPENDED,
    )
)
_STOPPED = frozenset(
    (
        PackmlState.STOPPING,
        PackmlState.STOPPED,
        PackmlState.CLEARING,
        PackmlState.HOLDING,
        PackmlState.HELD,
    )
)


def cell_part(status: CellStatus, description: CellDescription, node: str) -> dict[str, object]:
    """Return the cell: its state, why it stands, and what can be asked of it."""
    role = status.unauthenticated_role
    return {
        **plain_but(status, *_ELSEWHERE),
        'name': status.cell,
        'node': node,
        'state_kind': _kind(status),
        'since': status.state_since,
        'stop_reason': status.stop_reason.value if status.stop_reason else '',
        'stop_said': said_in_each(status.stop_message),
        'safety_said': said_in_each(status.safety),
        'wish': _wish_part(status.wish) if status.wish else None,
        'control': status.control.value,
        'unit_mode': status.unit_mode.value,
        'unauthenticated_role': role.value if role else '',
        'initialization': wait_parts(status.initialization, status.holds),
        'offers': cell_offers(status),
        'add': add_offer(),
        'manual_offers': manual_offers(status),
        'sections': [section.number for section in status.sections],
        'holds': [hold.id for hold in status.holds],
        'jobs': [job.id for job in status.jobs],
        'components': [component.name for component in description.components],
        'leadership': _leadership_part(status.leadership) if status.leadership else None,
    }


def _leadership_part(leadership: Leadership) -> dict[str, object]:
    """Return who leads and who stands by; what a standby has seen changes all the time."""
    standbys = [
        {**plain_but(standby, 'seq', 'trouble'), 'said': said_in_each(standby.trouble)}
        for standby in leadership.standbys
    ]
    return {**plain_but(leadership, 'standbys'), 'standbys': standbys}


_ELSEWHERE = (
    *('cell', 'stamp', 'seq', 'history', 'state_since', 'stop_reason', 'stop_words', 'wish'),
    *('safety_words', 'control', 'unit_mode', 'unauthenticated_role', 'initialization'),
    *('sections', 'holds', 'jobs', 'belt', 'flags', 'components', 'state_times', 'commands'),
    *('leadership', 'boot', 'uptime'),
)
"""Fields that other parts have, or this one under another name."""


def _wish_part(wish: Wish) -> dict[str, object]:
    return {**plain_but(wish, 'known'), 'who': named(wish.who, wish.known)}


def _kind(status: CellStatus) -> str:
    state, reason = status.state, status.stop_reason
    aborts = state in (PackmlState.ABORTING, PackmlState.ABORTED)
    if status.journal_failure or aborts:
        return TROUBLE
    if reason in (StopReason.OWN_FAULT, StopReason.EMERGENCY):
        return TROUBLE
    if state in _STOPPED or (status.stands and status.stands.cause is not StandCause.ORDER):
        return STOPPED
    return QUIET if state in _QUIET else WORKING


def now_part(status: CellStatus) -> dict[str, object]:
    """Return the moment of the status."""
    return {'seq': status.seq, 'history': status.history, 'stamp': status.stamp}


def hold_part(hold: Hold) -> dict[str, object]:
    """Return a hold with the answers that are possible."""
    return {
        **plain_but(hold, 'answers', 'answers_together', 'message_words'),
        'task': hold.task or '',
        'label': task_label(hold.task or '', hold.name),
        'item': hold.item or '',
        'job': hold.job or '',
        'together': list(hold.answers_together),
        'words': hold_words(hold),
        'said': said_in_each(hold.message),
        'is_pause': hold.is_pause,
        'offers': hold_offers(hold),
    }


def component_part(
    component: ComponentStatus, described: ComponentDescription | None
) -> dict[str, object]:
    """Return a component; its trouble in words."""
    return {
        **plain_but(component),
        'contested_said': said_in_each(component.contested),
        'sections': list(described.sections) if described else [],
        'trouble': component_trouble(component),
        'offers': component_offers(component),
    }


_NOTHING: Mapping[str, Ordered] = {}


def parts_of(
    status: CellStatus,
    description: CellDescription,
    scripts: Mapping[str, Script],
    node: str,
    orders: Mapping[str, Ordered] = _NOTHING,
) -> dict[str, object]:
    """Return all parts of a status.

    :param scripts: those that are known, by digest
    :param node: full name of the tree node
    :param orders: those of jobs, as far as they are known, by job
    """
    tasks = TaskParts(description, status.holds, status.stamp)
    parts: dict[str, object] = {
        'cell': cell_part(status, description, node),
        'now': now_part(status),
        'belt': belt_part(status, tasks),
        'flags': {'flags': to_plain(status.flags, whole=True)},
        'line': to_plain(description, whole=True),
        'why': why_part(status),
    }
    jobs = {job.id: job for job in status.jobs}
    for section in status.sections:
        parts[f'section/{section.number}'] = section_part(section, status, jobs, scripts, tasks)
    for hold in status.holds:
        parts[f'hold/{hold.id}'] = hold_part(hold)
    for job in status.jobs:
        script = scripts.get(job.digest)
        parts[f'job/{job.id}'] = job_part(
            job, status, script, tasks, orders.get(job.id, NOT_KNOWN)
        )
    described = {component.name: component for component in description.components}
    for component in status.components:
        part = component_part(component, described.get(component.name))
        parts[f'component/{component.name}'] = part
    return parts


# Jobs as parts.

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
        'end_unknown_said': said_in_each(job.end_unknown),
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


# Sections and the belt as parts.


def section_part(
    section: SectionStatus,
    status: CellStatus,
    jobs: Mapping[str, JobStatus],
    scripts: Mapping[str, Script],
    tasks: TaskParts,
) -> dict[str, object]:
    """Return a section with its whole task list.

    Without a cycle it is the list of the cycle that it finished in this beat, or of the next job.
    """
    finished = section.finished
    job = jobs.get(section.job or (finished.job if finished else '')) or _next_job(status)

    def parts(of: JobStatus | None, stands: SectionStatus) -> list[Part]:
        script = scripts.get(of.digest) if of else None
        listed = script.sections.get(section.number) if script else None
        return tasks.of_section(stands, listed) if listed else []

    return {
        'number': section.number,
        'slot': to_plain(section.slot, whole=True),
        'item': to_plain(section.item, whole=True),
        'job': section.job,
        'holds': [hold.id for hold in status.holds if hold.section == section.number],
        'waits': wait_parts(section.waits, status.holds),
        'tasks': parts(job, section),
        'finished': finished
        and {
            'item': finished.item,
            'job': finished.job,
            'tasks': parts(jobs.get(finished.job), _at_rest(section)),
        },
        'offers': item_offers(section.slot),
    }


def _at_rest(section: SectionStatus) -> SectionStatus:
    """Return a section without its cycle in hand: it shows what it finished."""
    return changed(section, job='', item=None, running=(), passed=(), failed=(), waits=())


def belt_part(status: CellStatus, tasks: TaskParts) -> dict[str, object]:
    """Return the belt."""
    belt = status.belt
    return {
        'moving': belt.moving,
        'running': tasks.in_flight(belt.running),
        'waits': wait_parts(belt.waits, status.holds),
    }


def _next_job(status: CellStatus) -> JobStatus | None:
    """Return the first job that goes on, or else the last one that ended."""
    live = (job for job in status.jobs if job.state not in OVER)
    return next(live, status.jobs[-1] if status.jobs else None)
