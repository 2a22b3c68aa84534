"""A second opinion on generated scripts: what the recipe and the cell say, and what became of it.

Written from docs/recipes.md and the rules, not from the planner.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, pairwise, product
from math import prod

from bt_orchestrator.model.cell import Capability, Cell, OnFailure
from bt_orchestrator.model.condition import Condition
from bt_orchestrator.model.recipe import Operation, Overrides, Recipe
from bt_orchestrator.model.reference import Reference
from bt_orchestrator.model.script import RunsFor, Script, SectionList, Task


def mistakes(script: Script, recipe: Recipe, overrides: Overrides, cell: Cell) -> list[str]:
    """Return what is wrong with a script."""
    places = _places(script)
    return [
        *_not_once(script, recipe),
        *_not_able(script, recipe, overrides, cell),
        *_out_of_order(script, recipe, overrides, places),
        *_trailing(script, recipe),
        *_at_once(script, cell),
        *_unguarded(script, cell),
        *_not_taken_out(script, places),
        *_not_together(script, recipe),
        *_not_prepared(script, cell),
    ]


MOST_BINDINGS = 20_000


def can_be_made(recipe: Recipe, overrides: Overrides, cell: Cell) -> bool | None:
    """Tell whether some binding keeps the order of a recipe; None: there are too many to try."""
    ways = [
        [
            (section, name, component.capabilities[can])
            for name, component in cell.components.items()
            for can in op.do
            if can in component.capabilities and overrides.bind.get(op.id, name) == name
            for section in component.sections or range(1, cell.conveyor.sections + 1)
        ]
        for op in recipe.operations
    ]
    if prod(map(len, ways)) > MOST_BINDINGS:
        return None
    names = [op.id for op in recipe.operations]
    return any(
        _keeps_order(dict(zip(names, binding, strict=True)), recipe) for binding in product(*ways)
    )


def _keeps_order(bound: dict[str, tuple[int, str, Capability]], recipe: Recipe) -> bool:
    """Tell whether items move down the belt only, and devices keep what they can."""
    together = {op for rework in recipe.reworks for op in rework.operations}
    kept = set()
    for op in recipe.operations:
        here = bound[op.id][0]
        if not bound['put'][0] <= here <= bound['take'][0]:
            return False
        named = {r.name for r in _named(op) if r.source == 'results' and r.name != op.id}
        if any(bound[before][0] > here for before in {*op.after, *op.needs.values(), *named}):
            return False
        for name, giver in op.needs.items():
            section, device, can = bound[giver]
            if name in can.holds:
                if here - section > can.holds[name] or {op.id, giver} & together:
                    return False
                kept.add((device, name, giver))
    if len({(device, name) for device, name, _ in kept}) < len(kept):
        return False
    return all(len({bound[op][0] for op in rework.operations}) == 1 for rework in recipe.reworks)


def _named(operation: Operation) -> Iterator[Reference]:
    for value in operation.options.values():
        if isinstance(value, Condition):
            yield from value.references


_Place = tuple[int, int, int, int]
"""Section, step, track, place in the track."""


def _places(script: Script) -> dict[str, _Place]:
    return {
        task.id: (number, step, track, place)
        for number, section in script.sections.items()
        for step, group in enumerate(section.steps)
        for track, members in enumerate(group.tracks)
        for place, task in enumerate(members)
    }


def _is_before(first: _Place, other: _Place) -> bool:
    if first[:2] != other[:2]:
        return first[:2] < other[:2]
    return first[2] == other[2] and first[3] < other[3]


def _not_once(script: Script, recipe: Recipe) -> Iterator[str]:
    listed = [task.id for section in script.sections.values() for task in section.tasks]
    if sorted(listed) != sorted(op.id for op in recipe.operations):
        yield f'operations {sorted(listed)}'


def _not_able(script: Script, recipe: Recipe, overrides: Overrides, cell: Cell) -> Iterator[str]:
    for op in recipe.operations:
        task, section = script.tasks[op.id], script.section_of(op.id)
        component = cell.components[task.component]
        if component.sections and section not in component.sections:
            yield f'{op.id}: {component.name} is not in section {section}'
        if task.name not in {can.task for n, can in component.capabilities.items() if n in op.do}:
            yield f'{op.id}: {component.name} cannot'
        if overrides.bind.get(op.id, component.name) != component.name:
            yield f'{op.id} is not where it is bound'


def _befores(operation: Operation, script: Script) -> set[str]:
    named = {r.name for r in script.tasks[operation.id].references if r.source == 'results'}
    return {*operation.after, *operation.needs.values(), *named}


def _out_of_order(
    script: Script, recipe: Recipe, overrides: Overrides, places: dict[str, _Place]
) -> Iterator[str]:
    for op in recipe.operations:
        for before in _befores(op, script):
            if not _is_before(places[before], places[op.id]):
                yield f'{op.id} does not come behind {before}'
    for listed in overrides.order:
        for before, after in pairwise(listed):
            if not _is_before(places[before], places[after]):
                yield f'{after} does not come behind {before}'


def _trail(section: SectionList) -> list[Task]:
    return [task for step in section.steps[section.turn_steps :] for task in step.tasks]


def _trailing(script: Script, recipe: Recipe) -> Iterator[str]:
    """The belt moves on while these run: nothing elsewhere may build on them."""
    for number, section in script.sections.items():
        if not any(step.requires_conveyor for step in section.steps) and section.turn_steps < len(
            section.steps
        ):
            yield f'section {number} never releases the belt'
        for task in _trail(section):
            if task.on_failure is OnFailure.REJECT:
                yield f'{task.id} may reject, and trails'
            for op in recipe.operations:
                if task.id in _befores(op, script) and script.section_of(op.id) != number:
                    yield f'{op.id} builds on {task.id}, which trails'


def _at_once(script: Script, cell: Cell) -> Iterator[str]:
    """Side by side run only components that say where, and in different places."""
    steps = (step for section in script.sections.values() for step in section.steps)
    for step in steps:
        for track, other in combinations(step.tracks, 2):
            for a, b in ((a, b) for a in track for b in other):
                spaces = [{*cell.components[task.component].workspaces} for task in (a, b)]
                if not all(spaces) or spaces[0] & spaces[1] or a.component == b.component:
                    yield f'{a.id} and {b.id} run at the same time'


def _unguarded(script: Script, cell: Cell) -> Iterator[str]:
    listed = [task for section in script.sections.values() for task in section.tasks]
    for a, b in combinations(listed, 2):
        spaces = [{*cell.components[task.component].workspaces} for task in (a, b)]
        apart = script.section_of(a.id) != script.section_of(b.id)
        for name in spaces[0] & spaces[1]:
            zones = [area for area in script.zones if area.name == name]
            if apart and not any({a.id, b.id} <= {*zone.tasks} for zone in zones):
                yield f'{a.id} and {b.id} may meet in {name}'


def _not_taken_out(script: Script, places: dict[str, _Place]) -> Iterator[str]:
    listed = [task for section in script.sections.values() for task in section.tasks]
    (put,) = (task for task in listed if task.qty_change == 1)
    takes = [task for task in listed if task.qty_change == -1]
    if sum(out.runs_for.includes(rejected=False) for out in takes) != 1:
        yield 'good items are not taken out once'
    for task in listed:
        if task.on_failure is OnFailure.REJECT and _is_before(places[put.id], places[task.id]):
            takers = [
                out
                for out in takes
                if out.runs_for is not RunsFor.GOOD and _is_before(places[task.id], places[out.id])
            ]
            if len(takers) != 1:
                yield f'an item that {task.id} rejects is taken out {len(takers)} times'
        if task.qty_change == 0 and not script.source <= places[task.id][0] <= script.sink:
            yield f'{task.id} is outside the line'


def _not_together(script: Script, recipe: Recipe) -> Iterator[str]:
    repeats = {rework.tasks: rework.times for rework in script.repeats}
    if repeats != {rework.operations: rework.times for rework in recipe.reworks}:
        yield f'repeats {repeats}'
    for rework in recipe.reworks:
        (track,) = script.step_of(rework.operations[0]).tracks
        if tuple(task.id for task in track) != rework.operations:
            yield f'{rework.operations} are no step'


def _not_prepared(script: Script, cell: Cell) -> Iterator[str]:
    used = {task.component for task in script.tasks.values()} | {'conveyor'}
    prepared = {task.component: task.id for task in script.initialization}
    for name in used:
        prepare = cell.components[name].prepare
        if prepare is None:
            continue
        if prepared.get(name) != prepare.id:
            yield f'{name} is not prepared'
        for other in prepare.after:
            first = cell.components[other].prepare
            if first is not None and not any(
                (dependency.upstream, dependency.downstream) == (first.id, prepare.id)
                for dependency in script.initialization_dependencies
            ):
                yield f'{name} is prepared before {other}'
