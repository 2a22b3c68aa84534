"""The data of a status in words, for all surfaces."""

from __future__ import annotations

import re
from collections.abc import Iterable

from bt_orchestrator.model.jobs.job_record import JobRecord
from bt_orchestrator.model.status import ComponentStatus, JobStatus
from bt_orchestrator.model.wait import Wait

_PLACE = re.compile(r'(\d+|init)\.\d+')
"""Id of a task whose script gives it none: section, or init, and number."""


def task_label(task: str, name: str) -> str:
    """Name a task in few words: its id; with its constant where the id is only its place.

    :param task: id in the script; empty: none
    :param name: task constant
    """
    return ' '.join(filter(None, (task, name))) if _PLACE.fullmatch(task) else task or name


def wait_words(waits: Iterable[Wait]) -> tuple[str, ...]:
    """Say what something waits for, each sentence once."""
    return tuple(dict.fromkeys(wait.reason for wait in waits))


def script_words(job: JobRecord | JobStatus) -> str:
    """Name what a job runs: its script, and the recipe that this was generated from."""
    if not job.recipe:
        return job.script
    version = '' if job.recipe_version is None else f' version {job.recipe_version}'
    return f'{job.script} from {job.recipe}{version}'


def job_count_words(job: JobStatus) -> str:
    """Say how far a job is; bad counts only when there are any."""
    counts = {
        'rejected': job.rejected,
        'missing': job.missing,
        'nonconforming': job.nonconforming,
    }
    bad = [f'{count} {name}' for name, count in counts.items() if count]
    return ', '.join([f'{job.packed} of {job.quantity} packed', *bad])


def component_trouble(component: ComponentStatus) -> str:
    """Say why no goal can be sent to a component; empty: one can."""
    if component.out_of_service_since is not None:
        return f'{component.name}: out of service, {component.out_of_service}'
    if not component.available:
        return f'{component.name}: no action server at {component.action}'
    if component.contested:
        return f'{component.name}: {component.contested}'
    if not component.ready:
        state = f'its state is {component.state}' if component.state else 'no state yet'
        return f'{component.name}: not ready, {state}'
    return ''
