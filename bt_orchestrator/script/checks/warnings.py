"""Warnings: probable mistakes in a valid cell file and its scripts."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from pathlib import Path
from typing import NamedTuple

from bt_orchestrator.base.errors import Finding, Refused
from bt_orchestrator.model.cell import CONVEYOR, Cell, OnFailure
from bt_orchestrator.model.recipe import Recipe
from bt_orchestrator.model.script import RunsFor, Script, Task
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.script.composing import compose
from bt_orchestrator.script.lookup import scripts_in
from bt_orchestrator.script.report import Place, Report, did_you_mean, listing
from bt_orchestrator.script.script_file import read_script
from bt_orchestrator.script.source_text import read_text
from bt_orchestrator.script.yaml_nodes import ListNode, MapNode, Node, place_of_key

_HOMING = re.compile(r'(^|[^a-z])hom(e|ing)([^a-z]|$)', re.IGNORECASE)


class ReadScript(NamedTuple):
    """A script without mistakes, and its file."""

    path: Path
    script: Script


def warnings(
    cell_file: Path,
    cell: Cell,
    given: Sequence[ReadScript],
    folders: Sequence[Path],
    types: ActionTypes,
) -> list[Finding]:
    """Return the warnings, in the order of the files.

    :param given: the scripts that are checked; those in the folders use names of the cell as well
    """
    report = Report(str(cell_file))
    unused = list(_unused(cell_file, cell, [given_script.script for given_script in given], types))
    if unused:
        others = [given_script.script for given_script in given] + list(
            _fitting(folders, cell, types)
        )
        unused = list(_unused(cell_file, cell, others, types))
    for place, what, hint in unused:
        report.add(place, what, hint)
    return [
        *report.findings,
        *chain.from_iterable(_of_script(given_script, cell) for given_script in given),
    ]


# --- the cell file ----------------------------------------------------------------------------


def _unused(
    cell_file: Path, cell: Cell, scripts: Iterable[Script], types: ActionTypes
) -> Iterator[tuple[Place, str, str]]:
    """Yield nominal times of labels that no script uses.

    Only types without a task field have labels; a constant that no script uses is none the less
    one of the type. A recipe may use the label of a capability at any time.
    """
    used: dict[str, set[str]] = {}
    for script in scripts:
        for task in script.tasks.values():
            used.setdefault(task.component, set()).add(task.name)
    root = compose(read_text(cell_file), Report(''))
    for name, component in cell.components.items():
        if types.action(component.type).has_task_field or name not in used:
            continue
        able = {capability.task for capability in component.capabilities.values()}
        for label in component.durations_s:
            if label not in used[name] | able:
                what = (
                    f'no script has a task `{label}` of `{name}`: its nominal time has no effect'
                )
                hint = did_you_mean(label, used[name], f'its tasks are {listing(used[name])}')
                yield place_of_key(root, 'components', name, 'durations', label), what, hint


def _fitting(folders: Sequence[Path], cell: Cell, types: ActionTypes) -> Iterator[Script]:
    """Yield the scripts in some folders that fit the cell."""
    for path in chain.from_iterable(map(scripts_in, folders)):
        try:
            yield read_script(path, cell, types)
        except Refused:
            continue


# --- scripts ----------------------------------------------------------------------------------


def _of_script(read: ReadScript, cell: Cell) -> tuple[Finding, ...]:
    report = Report(str(read.path))
    script = read.script
    listed = chain.from_iterable(script.sections[n].tasks for n in sorted(script.sections))
    nodes = _task_nodes(compose(read_text(read.path), Report('')))
    kinds: set[Kind] = set()
    written = (task for task in script.initialization if not task.is_implied)
    for task, node in zip(chain(written, listed), nodes, strict=True):
        kind = task.component, task.name
        without_time = timeless_words(kind, cell)
        if without_time is not None and kind not in kinds:
            report.add(node.place, *without_time)
        kinds.add(kind)
        for what, hint in chain(
            _repeated(task, script), _never_there(task, script), _left_on_the_belt(task, script)
        ):
            report.add(node.place, what, hint)
    return report.findings


def _repeated(task: Task, script: Script) -> Iterator[tuple[str, str]]:
    """Yield that a homing is done again for every job, though it is the same each time."""
    is_homing = _HOMING.search(task.name) or _HOMING.search(task.id)
    if task not in script.initialization or task.once or not is_homing:
        return
    if not task.refers:
        what = f'`{task.id}` is done again for every job, with the same arguments'
        yield what, 'write `once: true`, and it is skipped while it has succeeded before'


def _never_there(task: Task, script: Script) -> Iterator[tuple[str, str]]:
    """Yield the results that a task for rejected items names, and that no such item has.

    A good item that is rejected skips what comes behind (semantics 6.4), and the task that failed
    has no results (6.3). Only an item that an operator rejects later has them.
    """
    places = _places(script)
    rejecting = [other for other in script.tasks.values() if other.on_failure is OnFailure.REJECT]
    if task.runs_for is not RunsFor.REJECTED or not rejecting:
        return
    for reference in dict.fromkeys(task.references):
        giver = script.tasks[reference.name] if reference.source == 'results' else task
        if giver.runs_for is RunsFor.GOOD and all(
            _is_at_or_behind(places[giver.id], places[r.id]) for r in rejecting
        ):
            what = (
                f'`${{{reference}}}` has no value here: a rejected item never ran '
                f'`{giver.id}` well'
            )
            hint = (
                f'items are rejected by {listing(r.id for r in rejecting)}; refer to a task before'
            )
            yield what, hint


def _left_on_the_belt(task: Task, script: Script) -> Iterator[tuple[str, str]]:
    """Yield that the task takes out good items, and no task takes out rejected ones from there on.

    An operator or `abort_job` may reject any item on the belt; it then stops the belt (3.6).
    """
    if task.qty_change >= 0 or not task.runs_for.includes(rejected=False):
        return
    places = _places(script)
    takers = [
        taker
        for taker in script.tasks.values()
        if taker.qty_change < 0 and taker.runs_for.includes(rejected=True)
    ]
    if any(_is_at_or_behind(places[taker.id], places[task.id]) for taker in takers):
        return
    behind = f' behind `{takers[-1].id}`' if takers else ''
    what = (
        f'an item that an operator or `abort_job` rejects{behind} is never taken out: `{task.id}` '
        'runs for good items only'
    )
    hint = 'set `runs_for: all`, or each such item stops the belt until somebody takes it off'
    yield what, hint


_Place = tuple[int, int, int, int]
"""Of a task on its way along the belt: section, step, track, place in the track."""


def _places(script: Script) -> dict[str, _Place]:
    return {
        task.id: (number, step_number, track_number, place)
        for number, section in script.sections.items()
        for step_number, step in enumerate(section.steps)
        for track_number, track in enumerate(step.tracks)
        for place, task in enumerate(track)
    }


def _is_at_or_behind(place: _Place, other: _Place) -> bool:
    """Tell whether a task runs after another one, for the same item, or is that."""
    return place[:2] > other[:2] or (place[:3] == other[:3] and place[3] >= other[3])


def _task_nodes(root: Node | None) -> Iterator[Node]:
    """Yield the tasks of a script without mistakes: initialization, then along the belt."""
    if not isinstance(root, MapNode):
        return
    first, sections = root.find('initialization'), root.find('sections')
    if first is not None and isinstance(first.value, ListNode):
        yield from first.value.items
    if sections is not None and isinstance(sections.value, MapNode):
        for entry in sorted(sections.value.entries, key=lambda entry: int(entry.key.text)):
            yield from _tasks_in(entry.value)


def _tasks_in(node: Node) -> Iterator[Node]:
    """Yield the tasks of a list, a section or a group."""
    if isinstance(node, ListNode):
        yield from chain.from_iterable(map(_tasks_in, node.items))
        return
    keys = ('tasks', 'parallel', 'repeat')
    inner = [node.find(key) for key in keys] if isinstance(node, MapNode) else []
    below = [entry.value for entry in inner if entry is not None]
    yield from _tasks_in(below[0]) if below else [node]


# Tasks without a nominal time: who predicts with them, or chooses by them, is misled.

Kind = tuple[str, str]
"""A component and one of its task constants, or labels."""


def timeless_words(kind: Kind, cell: Cell) -> tuple[str, str] | None:
    """Say that the cell file has no nominal time for a task, and what to do; None: it has one.

    A cell file without any nominal times is not meant for predictions. The conveyor has one time
    for all its tasks.
    """
    name, task = kind
    component = cell.components[name]
    is_for_prediction = any(other.durations_s for other in cell.components.values())
    if name == CONVEYOR or not is_for_prediction or task in component.durations_s:
        return None
    default = component.default_duration_s
    what = f'`{task}` of `{name}` has no nominal time: predictions take {default:g} s'
    hint = f'add `{task}: SECONDS` to the `durations` of `{name}`'
    near = did_you_mean(task, component.durations_s, '')
    return what, f'{hint}; {near}' if near else hint


def of_scripts(scripts: Iterable[Script]) -> Iterator[Kind]:
    """Yield what scripts do."""
    for script in scripts:
        listed = (tasks.tasks for tasks in script.sections.values())
        for task in chain(script.initialization, *listed):
            yield task.component, task.name


def of_recipe(recipe: Recipe, cell: Cell) -> Iterator[Kind]:
    """Yield all that could do an operation of a recipe: `generate` chooses by these times."""
    wanted = {name for operation in recipe.operations for name in operation.do}
    for component in cell.components.values():
        for name, capability in component.capabilities.items():
            if name in wanted:
                yield component.name, capability.task


def timeless(cell_file: Path, cell: Cell, kinds: Iterable[Kind]) -> tuple[Finding, ...]:
    """Return a warning for each task without a nominal time, at its component in the cell file."""
    report = Report(str(cell_file))
    root = None
    for kind in dict.fromkeys(kinds):
        words = timeless_words(kind, cell)
        if words is not None:
            root = root or compose(read_text(cell_file), Report(''))
            report.add(place_of_key(root, 'components', kind[0], 'durations'), *words)
    return report.findings
