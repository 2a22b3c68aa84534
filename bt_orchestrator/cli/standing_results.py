"""Results that `simulate` gives with `mark_done`: `TASK.FIELD=VALUE`, against the task's type."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.cli.wrong_use import WrongUse
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.script import Script, Task
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.script.given_results import given_results, results_of, results_text


def standing_results(
    words: Sequence[str], scripts: Iterable[Script], cell: Cell, types: ActionTypes
) -> Mapping[str, Mapping[str, Any]]:
    """Return the results of each task, by its id.

    :raises WrongUse: there is no such task, or they do not fit its action type
    """
    tasks = {name: task for script in scripts for name, task in script.tasks.items()}
    fields: dict[str, list[str]] = defaultdict(list)
    for word in words:
        name = _task_of(word, tasks)
        fields[name].append(word[len(name) + 1 :])
    return {name: _read(name, given, tasks[name], cell, types) for name, given in fields.items()}


def _task_of(word: str, tasks: Mapping[str, Task]) -> str:
    """Return the task that a word is about; an id may have dots, so the longest that fits."""
    fitting = [name for name in tasks if word.startswith(f'{name}.')]
    if not fitting:
        raise WrongUse(
            f'--result is TASK.FIELD=VALUE, with a task of the scripts: {", ".join(tasks)}; '
            f'found {word!r}'
        )
    return max(fitting, key=len)


def _read(
    name: str, given: Sequence[str], task: Task, cell: Cell, types: ActionTypes
) -> Mapping[str, Any]:
    try:
        return given_results(
            results_text(results_of(given)), types.action(cell.components[task.component].type)
        )
    except (CommandRefused, ValueError) as why:
        raise WrongUse(f'--result of {name}: {why}') from why
