"""Parallel groups and the release of the conveyor (semantics 3.1, 3.8)."""

from __future__ import annotations

from bt_orchestrator.model.script import Release
from bt_orchestrator.script.drafts import ScriptDraft, SectionDraft, TaskDraft
from bt_orchestrator.script.report import Report


def check_sections(script: ScriptDraft, report: Report) -> None:
    """Report groups that would wait for themselves, and turns that would never be complete."""
    for section in script.lists:
        for step in section.steps:
            _check_group(step, report)
        _check_release(section, report)


def _check_group(step: tuple[tuple[TaskDraft, ...], ...], report: Report) -> None:
    """A component runs one task at a time, so its tasks belong into one track (2.5)."""
    owners: dict[str, tuple[int, TaskDraft]] = {}
    for number, track in enumerate(step):
        for task in track:
            if task.component is None:
                continue
            owner, first = owners.setdefault(task.component.name, (number, task))
            if owner != number:
                what = f'`{task.component.name}` cannot run two tasks at a time'
                hint = f'put it into one list with `{first.id}`, or behind the group'
                report.add(task.place('action'), what, hint)


def _check_release(section: SectionDraft, report: Report) -> None:
    if section.release is Release.END_OF_CYCLE:
        return
    tasks = list(section.tasks)
    if tasks and not any(task.task.requires_conveyor for task in tasks):
        what = f'section {section.name} has no task that requires the conveyor'
        hint = 'remove `release_conveyor`, or let a task require the conveyor'
        report.add(section.release_place, what, hint)
    for task in section.trailing:
        if task.may_reject and task.fields.is_sure('on_failure'):
            what = f'`{task.id}` cannot reject: it runs after the conveyor is released'
            hint = 'let it hold, continue or abort_job'
            report.add(task.place('on_failure'), what, hint)
