"""Scripts by name and by digest, and their drawings."""

from __future__ import annotations

import asyncio
import os
from dataclasses import replace
from pathlib import Path
from typing import cast
from xml.etree import ElementTree as ET

import pytest
from fakes.line import THREE, Line, expanded
from fakes.page_parts import status_of
from fakes.virtual_run import VirtualRun

from bt_orchestrator.extensions.page.web.archive.archive import Archive
from bt_orchestrator.extensions.page.web.archive.heard import Heard, HeardRecords
from bt_orchestrator.extensions.page.web.scripts.endpoints import Drawings, Drawn
from bt_orchestrator.extensions.page.web.scripts.shelf import Shelf
from bt_orchestrator.model.cell import Capability, Cell
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.ports.doors.following_door import Happened
from bt_orchestrator.ports.doors.known import Known
from bt_orchestrator.script.declared import OrderFiles
from bt_orchestrator.view.drawing.status_marks import NotThisLine

WITH_PARAMS = """
params:
  lot: {type: str}
  grams: {type: float, default: 2.5}
quantity: 4
"""


@pytest.fixture
def run() -> VirtualRun:
    line = Line(3)
    run = VirtualRun(line.cell, line.types)
    run.submit('J', line.script(THREE, 'heard'), 3)
    return run.go(until=2.0)


def shelf(
    run: VirtualRun, trees: Path, known: Known | None = None, recipes: Path | None = None
) -> Shelf:
    class AllHeard:
        async def records(self) -> HeardRecords:
            return HeardRecords('', 0, [Happened(event) for event in run.store.read()])

    async def no_moment() -> None:
        """Tell nothing: the node is silent."""

    archive = Archive(cast('Heard', AllHeard()))
    files = OrderFiles((trees,), (recipes,) if recipes else ())
    return Shelf(known or Known(), archive, files, no_moment)


def test_scripts_of_the_folders_with_their_parameters(run: VirtualRun, tmp_path: Path) -> None:
    (tmp_path / 'weighed.yaml').write_text(expanded(f'script: weighed{WITH_PARAMS}{THREE}'))
    (tmp_path / 'no script.yaml').write_text('cell: one\nconveyor: {}\n')
    (tmp_path / 'notes.txt').write_text('script: notes')
    (listed,) = asyncio.run(shelf(run, tmp_path).listed())
    assert (listed['name'], listed['digest'], listed['quantity']) == ('weighed', '', 4)
    lot, grams = listed['parameters']
    assert (lot['name'], lot['type'], lot['is_required']) == ('lot', 'str', True)
    assert (grams['name'], grams['default'], grams['is_required']) == ('grams', 2.5, False)


def test_changed_script_file_is_read_again(run: VirtualRun, tmp_path: Path) -> None:
    file = tmp_path / 'one.yaml'
    file.write_text(expanded(f'script: one{THREE}'))
    known = shelf(run, tmp_path)
    assert asyncio.run(known.listed())[0]['parameters'] == []
    file.write_text(expanded(f'script: one{WITH_PARAMS}{THREE}'))
    os.utime(file, (1.0, 1.0))
    assert [parameter['name'] for parameter in asyncio.run(known.listed())[0]['parameters']] == [
        'lot',
        'grams',
    ]
    file.unlink()
    assert asyncio.run(known.listed()) == []


def test_scripts_of_jobs_are_listed_with_their_digest(run: VirtualRun, tmp_path: Path) -> None:
    known, script = Known(), run.job().job.script
    known.scripts[digest(script)] = script
    (listed,) = asyncio.run(shelf(run, tmp_path, known).listed())
    assert (listed['name'], listed['digest']) == ('heard', digest(script))


def test_old_script_is_found_in_journal(run: VirtualRun, tmp_path: Path) -> None:
    scripts = shelf(run, tmp_path)
    assert asyncio.run(scripts.script(digest(run.job().job.script))) == run.job().job.script
    assert asyncio.run(scripts.script('0123')) is None


def drawn(drawings: Drawings, run: VirtualRun, status: CellStatus | None) -> Drawn:
    script = run.job().job.script
    return asyncio.run(drawings.drawn(digest(script), script, run.state.cell, status))


def test_drawing_tag_changes_only_with_drawing(run: VirtualRun) -> None:
    drawings = Drawings()
    plain = drawn(drawings, run, None)
    assert ET.fromstring(plain.svg.decode().partition('\n')[2]).tag.endswith('svg')
    live = drawn(drawings, run, status_of(run))
    assert live.tag != plain.tag
    assert drawn(drawings, run, status_of(run)).tag == live.tag
    run.go(until=4.5)
    later = drawn(drawings, run, status_of(run))
    assert later.tag != live.tag
    assert 'running' in later.svg.decode()
    assert drawn(drawings, run, None).tag == plain.tag


def test_the_state_of_another_cell_is_not_drawn(run: VirtualRun) -> None:
    with pytest.raises(NotThisLine):
        drawn(Drawings(), run, replace(status_of(run), cell='another'))


RECIPE = """\
recipe: P-1
version: {}
script: s
params: {{lot: {{type: str}}}}
operations:
  - {{id: glue, do: [glue, tape]}}
  - repeat:
    - {{id: look, do: look}}
    - {{id: close, do: close}}
  - {{do: glue}}
"""


def able(cell: Cell) -> Cell:
    """Return a cell in which two components can glue, and one can look."""
    first, second, *others = cell.components.values()
    able = [
        replace(first, capabilities={'glue': Capability('glue', 'TASK_A')}),
        replace(second, capabilities={name: Capability(name, 'T') for name in ('tape', 'look')}),
    ]
    return replace(cell, components={component.name: component for component in [*able, *others]})


def test_recipes_list_versions_and_bindable_components(run: VirtualRun, tmp_path: Path) -> None:
    (tmp_path / 'p.yaml').write_text(RECIPE.format(1))
    known = Known()
    known.cell = able(run.state.cell)
    recipes = shelf(run, tmp_path, known, recipes=tmp_path)
    (recipe,) = asyncio.run(recipes.recipes())
    (version,) = recipe['versions']
    assert (recipe['name'], version['version']) == ('P-1', 1)
    assert [field['name'] for field in version['parameters']] == ['lot']
    able_to_glue = list(known.cell.components)[:2]
    assert version['bind'] == [{'operation': 'glue', 'components': able_to_glue}]
    (tmp_path / 'p_2.yaml').write_text(RECIPE.format(2))
    (recipe,) = asyncio.run(recipes.recipes())
    assert [version['version'] for version in recipe['versions']] == [1, 2]


def test_unknown_cell_offers_no_component_to_bind(run: VirtualRun, tmp_path: Path) -> None:
    (tmp_path / 'p.yaml').write_text(RECIPE.format(1))
    (recipe,) = asyncio.run(shelf(run, tmp_path, recipes=tmp_path).recipes())
    assert recipe['versions'][0]['bind'] == []
