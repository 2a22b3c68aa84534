"""The key `likely`: how often a task runs and fails, for the expected pace (semantics 8.4)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

from bt_orchestrator.model.condition import Condition
from bt_orchestrator.model.script import GOES_ON, Likely
from bt_orchestrator.script.drafts import TaskDraft
from bt_orchestrator.script.report import Report
from bt_orchestrator.script.yaml_nodes import MapNode

_ITS_CONDITION = ('when', 'unless')
_ITS_FAILURE = ('fails_unless', 'on_failure', 'continue_if_fail')


def read_likely(
    drafts: Iterable[TaskDraft], conditions: Mapping[str, Condition | None], report: Report
) -> dict[str, Likely]:
    """Return what is likely of tasks, by their ids.

    :param conditions: of the tasks, by their ids
    """
    entries = {draft.id: (draft, likely) for draft in drafts if (likely := _read(draft, report))}
    by_condition: dict[Condition, tuple[TaskDraft, float]] = {}
    for name, (draft, likely) in entries.items():
        condition = conditions.get(name)
        if condition is None or likely.runs is None:
            continue
        holds = 1 - likely.runs if condition.negated else likely.runs
        other, before = by_condition.setdefault(replace(condition, negated=False), (draft, holds))
        if abs(holds - before) > 1e-9:
            what = f'`{name}` and `{other.id}` have one condition, but not one likelihood of it'
            runs = 1 - before if condition.negated else before
            hint = f'write {runs:g}, or change that in line {other.place("likely").line}'
            report.add(draft.place('likely'), what, hint)
    return {name: likely for name, (_, likely) in entries.items()}


def _read(draft: TaskDraft, report: Report) -> Likely | None:
    fields = draft.fields
    node = fields.value('likely')
    if node is None:
        return None
    may = {'runs': any(map(fields.has, _ITS_CONDITION)), 'fails': _may_fail(draft)}
    table = fields.table('likely') if isinstance(node, MapNode) else None
    if table is not None:
        shares = {name: table.share(name) for name in may if table.has(name)}
        if not shares and table.is_sure(*may):
            what = '`likely` says nothing'
            report.add(node.place, what, 'write `runs` or `fails` with a number from 0 to 1')
    else:
        share = fields.share('likely')
        if share is None:
            return None
        shares = {'runs' if may['runs'] else 'fails': share}
        if all(may.values()):
            what = f'`likely` does not say whether `{draft.id}` runs or fails so often'
            hint = f'write `likely: {{runs: {share:g}}}`, `likely: {{fails: {share:g}}}`, or both'
            report.add(node.place, what, hint)
    if fields.is_sure(*_ITS_CONDITION, *_ITS_FAILURE):
        for what, hint in _out_of_place(draft, [name for name in shares if not may[name]]):
            report.add(node.place, what, hint)
    return Likely(**shares)


def _may_fail(draft: TaskDraft) -> bool:
    """Tell whether a failure of it is nothing out of the ordinary: the line goes on by itself."""
    return draft.fields.has('fails_unless') or draft.task.on_failure in GOES_ON


def _out_of_place(draft: TaskDraft, names: Iterable[str]) -> Iterator[tuple[str, str]]:
    if 'runs' in names:
        what = f'`{draft.id}` has no condition, so it runs for every good item'
        yield what, 'give it `when` or `unless`, or leave `runs` out'
    if 'fails' in names:
        what = f'a failure of `{draft.id}` is held for a person, so no pace can count it'
        yield (
            what,
            (
                'give it `when`, `unless`, `fails_unless`, `on_failure: reject` or '
                '`on_failure: continue`, or remove `likely`'
            ),
        )
