"""The parts that a page makes of a virtual run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, cast

from fakes.line import TYPES
from fakes.virtual_run import VirtualRun

from bt_orchestrator.engine.runtime.overview import Overview, description_of
from bt_orchestrator.extensions.page.web.parts import parts_of
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.status import CellStatus

NODE = '/cell_1/bt_orchestrator'

Parts = Mapping[str, dict[str, Any]]


def status_of(run: VirtualRun) -> CellStatus:
    """Return the status of now."""
    return Overview(run.sim.orchestrator).status(run.now)


def scripts_of(run: VirtualRun) -> dict[str, Script]:
    """Return the scripts of all jobs that are listed."""
    listed = [*run.state.jobs.first(1000), *run.state.ended.values()]
    return {digest(job.job.script): job.job.script for job in listed}


def page_parts(run: VirtualRun) -> Parts:
    """Return what the page shows now."""
    status, description = status_of(run), description_of(run.state.cell, TYPES)
    return cast('Parts', parts_of(status, description, scripts_of(run), NODE))


def marks(parts: Parts, section: int) -> list[tuple[str, str]]:
    """Return the tasks of a section, each with its mark."""
    return [(task['id'], task['mark']) for task in parts[f'section/{section}']['tasks']]


def offered(part: Mapping[str, Any]) -> list[str]:
    """Return the names of the requests that a part offers."""
    return [offer['name'] for offer in part['offers']]


def root_of(parts: Parts, part: str) -> tuple[str, str]:
    """Return the root cause for which a part waits: its part and its kind."""
    (root,) = (c['root'] for c in parts['why']['chains'] if c['part'] == part)
    return root['part'], root['kind']


def way_of(parts: Parts, part: str) -> list[str]:
    """Return the parts on the way to the root cause."""
    (links,) = (c['links'] for c in parts['why']['chains'] if c['part'] == part)
    return [link['to'] for link in links]
