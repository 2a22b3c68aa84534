"""Reading a recipe: how one item is made, checked against what a cell can do.

Which component does what is not decided here; `planning` does that.
"""

from __future__ import annotations

from pathlib import Path

from bt_orchestrator.extensions.recipes.reading.operation_reader import OperationReader
from bt_orchestrator.extensions.recipes.reading.operation_values import OperationValues
from bt_orchestrator.extensions.recipes.reading.shelf import OperationDraft, RecipeDraft
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.recipe import Operation, Recipe, Rework
from bt_orchestrator.model.script import RunsFor
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.script.checks.balance import check_placing, check_taking
from bt_orchestrator.script.checks.structure import check_repeats
from bt_orchestrator.script.conditions.likely import read_likely
from bt_orchestrator.script.declared import read_hold_after, read_parameters
from bt_orchestrator.script.fields import Fields, file_fields
from bt_orchestrator.script.names import check_id
from bt_orchestrator.script.orders.recipe_keys import RECIPE
from bt_orchestrator.script.report import Report
from bt_orchestrator.script.source_text import read_text
from bt_orchestrator.script.task_values import check_serials, read_lots


def read_recipe(path: Path, cell: Cell, types: ActionTypes) -> Recipe:
    """Read a recipe, and check what can be known of it before anything is planned.

    :raises Refused: with every mistake in it
    """
    return parse_recipe(read_text(path), str(path), cell, types)


def parse_recipe(text: str, file: str, cell: Cell, types: ActionTypes) -> Recipe:
    """Read the text of a recipe; the file's name stands in the findings.

    :raises Refused: with every mistake in it
    """
    report = Report(file)
    fields = file_fields(text, RECIPE, report)
    recipe = _recipe(fields, cell, types, report)
    report.refuse()
    return recipe


def _recipe(fields: Fields, cell: Cell, types: ActionTypes, report: Report) -> Recipe:
    """Return the recipe; it is of use only if nothing was reported."""
    names = {'recipe': 'recipe name', 'script': 'script name'}
    texts = {key: fields.text(key) for key in names}
    for key, text in texts.items():
        if text is not None:
            check_id(text, names[key], fields.place(key), report)
    version = fields.optional_whole('version')
    draft = RecipeDraft(fields)
    read_parameters(draft, report)
    OperationReader(draft, cell, types, report).read()
    operations = tuple(_operation(draft, operation, report) for operation in draft.operations)
    conditions = {operation.id: operation.options.get('condition') for operation in operations}
    check_balance(draft, report)
    check_repeats(draft, report)
    check_serials(draft.operations, report)
    return Recipe(
        name=texts['recipe'] or '',
        version=version or 0,
        script=texts['script'] or '',
        operations=operations,
        params=draft.params,
        reworks=tuple(
            Rework(tuple(task.id for task in repeat.tasks), repeat.times)
            for repeat in draft.repeats
        ),
        lots=read_lots(draft, report),
        likely=read_likely(draft.operations, conditions, report),
        hold_after=read_hold_after(fields),
        first_piece=fields.switch('first_piece'),
    )


def _operation(draft: RecipeDraft, operation: OperationDraft, report: Report) -> Operation:
    values = OperationValues(draft, operation, report)
    return Operation(
        id=operation.id,
        do=operation.does,
        after=operation.after,
        parameters=values.parameters(),
        needs=values.needs(),
        options=values.options(),
    )


# A recipe as a whole: every item is placed once and taken out.


def check_balance(recipe: RecipeDraft, report: Report) -> None:
    """Report what would leave an item unplaced or on the belt, or move it twice (3.2)."""
    agreed = [_check_agreement(operation, report) for operation in recipe.operations]
    placing = [operation for operation in recipe.operations if operation.task.qty_change > 0]
    taking = [operation for operation in recipe.operations if operation.task.qty_change < 0]
    for draft in placing:
        check_placing(draft, report)
    for draft in taking:
        check_taking(draft, report)
    for draft in placing[1:]:
        what = f'two operations place the item: `{placing[0].id}` and `{draft.id}`'
        report.add(draft.place('do'), what, 'keep one of them')
    good = [draft for draft in taking if draft.task.runs_for.includes(rejected=False)]
    for draft in good[1:]:
        what = f'a good item is taken out twice, by `{good[0].id}` and by `{draft.id}`'
        report.add(draft.place('do'), what, 'keep one, or set `runs_for: rejected` on the other')
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
    changes = {
        candidate.capability.options.get('qty_change', 0): candidate
        for candidate in operation.candidates
    }
    if len(changes) > 1:
        first, second = list(changes.values())[:2]
        what = f'{first} and {second} change the quantity differently'
        hint = 'let `do` name capabilities with the same `qty_change`'
        report.add(operation.place('do'), what, hint)
    return len(changes) == 1
