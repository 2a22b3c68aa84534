"""Repeats: what must not be done twice, and what could never be (semantics 3.9)."""

from __future__ import annotations

from bt_orchestrator.script.drafts import ScriptDraft, TaskDraft
from bt_orchestrator.script.report import Report


def check_repeats(script: ScriptDraft, report: Report) -> None:
    """Report repeats that would move an item twice, or that never begin a round."""
    for repeat in script.repeats:
        for task in repeat.tasks:
            if task.task.qty_change and task.fields.is_sure('qty_change'):
                what = f'`{task.id}` moves the item, and cannot be repeated'
                report.add(task.place('qty_change'), what, 'put it before or behind the repeat')
        if repeat.tasks and not any(map(_is_judged, repeat.tasks)):
            what = (
                f'no {script.step} of this repeat has a verdict, so nothing would ever repeat it'
            )
            hint = 'give one of them `fails_unless`; for failed attempts there is `retries`'
            report.add(repeat.place, what, hint)


def _is_judged(task: TaskDraft) -> bool:
    return task.fields.has('fails_unless') or not task.fields.is_sure('fails_unless')
