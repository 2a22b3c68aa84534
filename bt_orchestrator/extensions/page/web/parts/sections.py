"""Sections and the belt as parts."""

from __future__ import annotations

from collections.abc import Mapping

from bt_orchestrator.extensions.page.web.offers import item_offers
from bt_orchestrator.extensions.page.web.parts.tasks import Part, TaskParts
from bt_orchestrator.extensions.page.web.parts.waits import wait_parts
from bt_orchestrator.model.codec import to_plain
from bt_orchestrator.model.frozen import changed
from bt_orchestrator.model.jobs.isa95 import OVER
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.status import CellStatus, JobStatus, SectionStatus


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
