"""Reading a recipe: how one item is made, checked against what a cell can do.

Which component does what is not decided here; `planning` does that.
"""

from __future__ import annotations

from pathlib import Path

from bt_orchestrator.extensions.recipes.reading.balance import check_balance
from bt_orchestrator.extensions.recipes.reading.drafts import OperationDraft, RecipeDraft
from bt_orchestrator.extensions.recipes.reading.operation_reader import OperationReader
from bt_orchestrator.extensions.recipes.reading.operation_values import OperationValues
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.recipe import Operation, Recipe, Rework
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.script.checks.repeats import check_repeats
from bt_orchestrator.script.conditions.likely import read_likely
from bt_orchestrator.script.fields import Fields, file_fields
from bt_orchestrator.script.identity_reader import check_serials, read_lots
from bt_orchestrator.script.names import check_id
from bt_orchestrator.script.orders.recipe_keys import RECIPE
from bt_orchestrator.script.parameters import read_parameters
from bt_orchestrator.script.report import Report
from bt_orchestrator.script.source_text import read_text


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
    operations = tuple(_operation(draft, one, report) for one in draft.operations)
    conditions = {one.id: one.options.get('condition') for one in operations}
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
            Rework(tuple(one.id for one in repeat.tasks), repeat.times) for repeat in draft.repeats
        ),
        lots=read_lots(draft, report),
        likely=read_likely(draft.operations, conditions, report),
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
