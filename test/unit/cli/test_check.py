"""The verb `check`, without ROS 2."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import pytest
from fakes.action_types import FakeActionTypes
from fakes.shipped import REFERENCE_CELL, STUCK, TREES

from bt_orchestrator.cli.check import add_arguments, check
from bt_orchestrator.errors import Refused

TYPES = FakeActionTypes()
FITS = 'fits cell reference_cell'


def checked(*words: str | Path, cell: Path = REFERENCE_CELL) -> int:
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    return check(parser.parse_args([*map(str, words), '--cell', str(cell)]), TYPES)


def mistakes(*words: str | Path, cell: Path = REFERENCE_CELL) -> list[str]:
    with pytest.raises(Refused) as refused:
        checked(*words, cell=cell)
    return [str(finding) for finding in refused.value.findings]


@pytest.fixture
def bad(tmp_path: Path) -> Path:
    path = tmp_path / 'bad.yaml'
    path.write_text(STUCK.read_text().replace('TASK_A', 'TASKA'))
    return path


def test_a_script_that_fits_is_summed_up(capsys: pytest.CaptureFixture[str]) -> None:
    assert checked(TREES / 'reference_process.yaml', TREES / 'inspect_and_assemble.yaml') == 0
    assert capsys.readouterr().out.splitlines() == [
        f'reference_process: 9 tasks in 5 sections and 3 of initialization, {FITS}',
        f'inspect_and_assemble: 8 tasks in 5 sections and 1 of initialization, {FITS}',
    ]


def test_scripts_are_looked_up_by_name_in_the_folders_named(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert checked('reference_process', '--trees', STUCK.parent, '--trees', TREES) == 0
    assert capsys.readouterr().out.startswith('reference_process: ')


def test_a_script_that_gets_stuck_is_refused_where_its_flag_is_declared() -> None:
    (found,) = mistakes(STUCK)
    assert found.startswith(f'{STUCK}:14:5: the line gets stuck with stuck, at item 4 in beat 3: ')
    assert 'section 2 is waiting for assemble to take flag read_before_assemble' in found
    assert 'section 4 is waiting for an item' in found
    assert 'belt is waiting for section 2 to finish with item 2' in found
    assert found.endswith('; capacity 2 of flag read_before_assemble frees it')


def test_the_mistakes_of_all_scripts_are_told(bad: Path, tmp_path: Path) -> None:
    missing = tmp_path / 'missing.yaml'
    found = mistakes(bad, STUCK, missing)

    assert len(found) == 4
    assert all(line.startswith(f'{bad}:') and 'TASKA' in line for line in found[:2])
    assert found[2].startswith(f'{STUCK}:14:5: the line gets stuck')
    assert found[3].startswith(f'{missing}:1:1: there is no script file')


def test_the_mistakes_of_the_cell_are_told_too(tmp_path: Path) -> None:
    cell = tmp_path / 'cell.yaml'
    cell.write_text(REFERENCE_CELL.read_text().replace('section: 2', 'section: 6'))
    nowhere = tmp_path / 'nowhere.yaml'
    found = mistakes(STUCK, nowhere, cell=cell)

    assert [line.split(':')[0] for line in found] == [str(cell), str(nowhere)]
    assert 'section 6 is not on the belt' in found[0]


def test_findings_as_json(bad: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert checked(bad, '--json') == 1
    answer = json.loads(capsys.readouterr().out)

    assert answer['ok'] is False
    assert answer['findings'][0]['file'] == str(bad)
    assert answer['findings'][0]['line'] == 8
    assert set(answer['findings'][0]) == {'file', 'line', 'column', 'what', 'hint'}


def test_no_findings_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert checked(TREES / 'reference_process.yaml', '--json') == 0
    assert json.loads(capsys.readouterr().out) == {'findings': [], 'ok': True}
