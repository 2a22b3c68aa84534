"""From recipes to scripts."""

from __future__ import annotations

from dataclasses import replace

from fakes.action_types import FakeActionTypes
from fakes.deck_recipe import ROOT, deck_cell, deck_recipe

from bt_orchestrator.model.script import Script, SectionList, Step, Task
from bt_orchestrator.planning.generate import generate
from bt_orchestrator.script.script_file import read_script
from bt_orchestrator.sim.pace_judge import PaceJudge
from bt_orchestrator.store.memory import MemoryStore

TYPES = FakeActionTypes()


def renamed(script: Script, names: dict[str, str]) -> Script:
    """Return a script with other task ids."""

    def of(task: Task) -> Task:
        return replace(task, id=names.get(task.id, task.id))

    def section(one: SectionList) -> SectionList:
        steps = (Step(tuple(tuple(map(of, track)) for track in step.tracks)) for step in one.steps)
        return replace(one, steps=tuple(steps))

    sections = {number: section(one) for number, one in script.sections.items()}
    return replace(script, sections=sections)


def test_the_reference_recipe_becomes_the_reference_process() -> None:
    cell, recipe = deck_cell(), deck_recipe()
    found = generate(cell, recipe, judge=PaceJudge(cell, TYPES, MemoryStore))
    written = read_script(ROOT / 'trees' / 'reference_process.yaml', cell, TYPES)
    ids = [task.id for one in written.sections.values() for task in one.tasks]
    names = dict(zip(ids, [one.id for one in recipe.operations], strict=True))
    assert found.script == renamed(written, names)
    assert {name: made.component for name, made in found.made.items()} == {
        task.id: task.component for task in found.script.tasks.values()
    }
    assert found.claim.per_item_s == 6.5
