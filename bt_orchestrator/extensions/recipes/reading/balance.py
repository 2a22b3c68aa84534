"""A recipe as a whole: every item is placed once and taken out."""

from __future__ import annotations

from bt_orchestrator.extensions.recipes.reading.drafts import OperationDraft, RecipeDraft
from bt_orchestrator.model.script import RunsFor
from bt_orchestrator.script.checks.balance import check_placing, check_taking
from bt_orchestrator.script.report import Report


def check_balance(recipe: RecipeDraft, report: Report) -> None:
    """Report what would leave an item unplaced or on the belt, or move it twice (3.2)."""
    agreed = [_check_agreement(one, report) for one in recipe.operations]
    placing = [one for one in recipe.operations if one.task.qty_change > 0]
    taking = [one for one in recipe.operations if one.task.qty_change < 0]
    for one in placing:
        check_placing(one, report)
    for one in taking:
        check_taking(one, report)
    for one in placing[1:]:
        what = f'two operations place the item: `{placing[0].id}` and `{one.id}`'
        report.add(one.place('do'), what, 'keep one of them')
    good = [one for one in taking if one.task.runs_for.includes(rejected=False)]
    for one in good[1:]:
        what = f'a good item is taken out twice, by `{good[0].id}` and by `{one.id}`'
        report.add(one.place('do'), what, 'keep one, or set `runs_for: rejected` on the other')
    if not recipe.tasks_are_complete or not all(agreed):
        return
    place = recipe.fields.place('operations')
    if not placing and recipe.operations:
        hint = 'let an operation do a capability with `qty_change: 1`'
        report.add(place, 'nothing places the item', hint)
    if not taking and recipe.operations:
        hint = 'let the last operation do a capability with `qty_change: -1`'
        report.add(place, 'nothing takes the item out', hint)
    elif taking and not good:
        what = 'only rejected items are taken out'
        report.add(
            taking[0].place('runs_for'), what, f'remove `runs_for: {RunsFor.REJECTED.value}`'
        )


def _check_agreement(operation: OperationDraft, report: Report) -> bool:
    """Tell whether all that can do it move the item alike; report it if not."""
    changes = {one.capability.options.get('qty_change', 0): one for one in operation.candidates}
    if len(changes) > 1:
        first, second = list(changes.values())[:2]
        what = f'{first} and {second} change the quantity differently'
        hint = 'let `do` name capabilities with the same `qty_change`'
        report.add(operation.place('do'), what, hint)
    return len(changes) == 1
