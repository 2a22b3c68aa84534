"""The reference recipe becomes the reference process, on its own cell and on others."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from fakes.action_types import FakeActionTypes

from bt_orchestrator.extensions.recipes.planning.generate import generate
from bt_orchestrator.extensions.recipes.planning.outcome import Generated
from bt_orchestrator.extensions.recipes.reading.recipe_file import read_recipe
from bt_orchestrator.model.script import Script, SectionList, Step, Task
from bt_orchestrator.script.cell_file import parse_cell
from bt_orchestrator.script.script_file import parse_script
from bt_orchestrator.sim.pace_judge import PaceJudge
from bt_orchestrator.store.memory import MemoryStore

ROOT = Path(__file__).parents[5]
TYPES = FakeActionTypes()
CELL = (ROOT / 'config' / 'cell_with_capabilities.yaml').read_text()
PROCESS = (ROOT / 'trees' / 'reference_process.yaml').read_text()


def compared(cell_text: str, process: str) -> Generated:
    """Generate for a cell, and hold it against a script that was written for it by hand."""
    cell = parse_cell(cell_text, 'cell.yaml', TYPES)
    recipe = read_recipe(ROOT / 'recipes' / 'wm_100.yaml', cell, TYPES)
    result = generate(cell, recipe, judge=PaceJudge(cell, TYPES, MemoryStore))
    written = parse_script(process, 'process.yaml', cell, TYPES)
    ids = [task.id for entry in written.sections.values() for task in entry.tasks]
    names = dict(zip(ids, [entry.id for entry in recipe.operations], strict=True))
    assert result.script == _renamed(written, names)
    return result


def _renamed(script: Script, names: dict[str, str]) -> Script:
    """Return a script with other task ids."""

    def of(task: Task) -> Task:
        return replace(task, id=names[task.id])

    def section(old: SectionList) -> SectionList:
        steps = (Step(tuple(tuple(map(of, track)) for track in step.tracks)) for step in old.steps)
        return replace(old, steps=tuple(steps))

    sections = {number: section(old) for number, old in script.sections.items()}
    return replace(script, sections=sections)


def test_the_reference_recipe_becomes_the_reference_process() -> None:
    result = compared(CELL, PROCESS)
    assert str(result.claim) == '6.5 s for each item, proven fastest'
    assert {name: made.component for name, made in result.made.items()} == {
        task.id: task.component for task in result.script.tasks.values()
    }


def test_longer_line_with_other_names_is_planned_correctly() -> None:
    """The line is a section longer, the drill and its action are renamed, another one deburrs."""
    cell = CELL.replace('sections: 5', 'sections: 6')
    for section in (5, 4, 3):
        cell = cell.replace(f'section: {section}\n', f'section: {section + 1}\n')
    cell = cell.replace('component_1a', 'driller')
    cell = cell.replace('      deburr: {task: TASK_A}', '      polish: {task: TASK_A}')
    cell += """  deburrer:
    section: 3
    action: /deburrer/task
    type: bt_orchestrator_interfaces/action/Component
    durations: {TASK_B: 2.0}
    capabilities:
      deburr: {task: TASK_B, timeout: 9.0}
"""
    process = PROCESS
    for section in (5, 4):
        process = process.replace(f'\n  {section}:\n', f'\n  {section + 1}:\n')
    process = process.replace('component_1a', 'driller').replace(
        'TASK_A, action: /component_2a/task', 'TASK_B, action: /deburrer/task, timeout: 9.0'
    )
    assert compared(cell, process).made['deburr'].component == 'deburrer'


def test_with_a_second_drill_the_work_is_spread() -> None:
    """Both could do it; where the circle is as long with each, the load decides."""
    cell = CELL.replace(
        '      deburr: {task: TASK_A}', '      deburr: {task: TASK_A}\n      drill: {task: TASK_A}'
    )
    result = compared(cell, PROCESS)
    assert result.made['drill'].alternatives == ('component_2a',)
