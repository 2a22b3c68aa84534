"""A status as parts, by the keys under which the page knows them."""

from __future__ import annotations

from collections.abc import Mapping

from bt_orchestrator.extensions.page.web.parts.cell import (
    cell_part,
    component_part,
    hold_part,
    now_part,
)
from bt_orchestrator.extensions.page.web.parts.jobs import NOT_KNOWN, job_part
from bt_orchestrator.extensions.page.web.parts.sections import belt_part, section_part
from bt_orchestrator.extensions.page.web.parts.tasks import TaskParts
from bt_orchestrator.extensions.page.web.parts.waits import why_part
from bt_orchestrator.model.codec import to_plain
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.status import CellDescription, CellStatus
from bt_orchestrator.ports.doors.known import Ordered

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
    described = {one.name: one for one in description.components}
    for component in status.components:
        part = component_part(component, described.get(component.name))
        parts[f'component/{component.name}'] = part
    return parts
