"""What the last version left: its files are read, its journal tells what it told then."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest
from fakes.shipped import ROOT

from bt_orchestrator.cli.main import main

KEPT = ROOT / 'test' / 'data' / 'release_0_1_0'
CELL = ('--cell', str(KEPT / 'cell.yaml'))
SAID = {
    'history': ('history', '--json', '--items'),
    'alarms': ('alarms', '--json'),
    'record': ('history', '--record', '--job', 'WO-2001'),
    'report': ('report', '--json', '--job', 'WO-1001', *CELL),
}


def names(folder: str) -> list[str]:
    return sorted(path.name for path in (KEPT / folder).glob('*.yaml'))


@pytest.mark.parametrize('name', names('trees'))
def test_a_script_fits_its_cell(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(['check', str(KEPT / 'trees' / name), *CELL]) == 0, capsys.readouterr()
    assert 'fits cell reference_cell' in capsys.readouterr().out


@pytest.mark.parametrize('name', names('orders'))
def test_an_order_is_predicted(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    words = ['simulate', str(KEPT / 'orders' / name), *CELL, '--trees', str(KEPT / 'trees')]
    assert main(words) == 0, capsys.readouterr()
    assert 'total time' in capsys.readouterr().out


def test_a_file_of_shifts_is_read(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(['check', '--shifts', str(KEPT / 'shifts.yaml')]) == 0, capsys.readouterr()


@pytest.mark.parametrize(
    ('name', 'cell'), [('gear_motor', 'gear_motor_cell'), ('wm_100', 'cell_with_capabilities')]
)
def test_a_recipe_fits_its_cell(name: str, cell: str, capsys: pytest.CaptureFixture[str]) -> None:
    words = ['check', str(KEPT / 'recipes' / f'{name}.yaml'), '--cell', str(KEPT / f'{cell}.yaml')]
    assert main(words) == 0, capsys.readouterr()


@pytest.fixture(scope='module')
def journal(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp('kept')
    shutil.unpack_archive(KEPT / 'journal.tar.gz', folder)
    return folder / 'journal' / 'cell.db'


@pytest.mark.parametrize('name', SAID)
def test_verb_output_contains_that_of_kept_release(
    name: str, journal: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*SAID[name], '--journal', str(journal)]) == 0, capsys.readouterr()
    now = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    then = [
        json.loads(line) for line in (KEPT / 'said' / f'{name}.jsonl').read_text().splitlines()
    ]
    assert then
    assert list(map(missing, then, now)) == [[] for _ in then]


def missing(then: Any, now: Any, where: str = '') -> list[str]:
    """Return the places in what was said then that are not said, or differ, now."""
    if isinstance(then, dict) and isinstance(now, dict):
        return [
            lack
            for key, value in then.items()
            for lack in missing(value, now.get(key, 'no such field'), f'{where}/{key}')
        ]
    if isinstance(then, list) and isinstance(now, list) and len(then) == len(now):
        pairs = enumerate(zip(then, now, strict=True))
        return [lack for at, pair in pairs for lack in missing(*pair, f'{where}/{at}')]
    return [] if then == now else [f'{where}: {then!r} was {now!r}']


def test_a_lost_field_would_be_seen() -> None:
    then = {'job': 'A', 'items': [{'how': 'packed', 'good': True}]}
    assert missing(then, {'job': 'A', 'items': [{'how': 'packed'}], 'more': 1}) == [
        "/items/0/good: True was 'no such field'"
    ]
