"""Lines with several jobs, most of which wait in the queue."""

from __future__ import annotations

from fakes.line import THREE, Line
from fakes.virtual_run import VirtualRun

from bt_orchestrator.model.script import Script

LINE = Line()
SCRIPT = LINE.script(THREE)


def queued(names: str = 'KLM', script: Script = SCRIPT) -> VirtualRun:
    """Give a line on which J runs, with jobs of one item behind it."""
    run = VirtualRun(LINE.cell, LINE.types)
    run.submit('J', script, 3)
    assert run.add(*((name, script) for name in names)).accepted
    return run


def queue(run: VirtualRun) -> str:
    """Return the jobs that wait, in their order."""
    return ''.join(job.job.id for job in run.state.queue)


def begun(run: VirtualRun) -> list[str]:
    """Return the jobs in the order in which they started."""
    return run.order('job.started', 'job')
