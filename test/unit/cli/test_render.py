"""The verb `render`, without ROS 2 and without `dot`."""

from __future__ import annotations

import argparse
import json
import os
from pathlib import Path

import pytest
from fakes.action_types import FakeActionTypes
from fakes.shipped import REFERENCE_CELL, STUCK, TREES

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.cli.render import CannotRead, CannotWrite, add_arguments, render, run
from bt_orchestrator.model.codec import to_plain
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.status import CellStatus


def arguments(*words: str | Path) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    return parser.parse_args([*map(str, words), '--cell', str(REFERENCE_CELL)])


def rendered(*words: str | Path) -> int:
    return render(arguments(*words), FakeActionTypes())


def test_a_line_is_written_as_the_shipped_picture(tmp_path: Path) -> None:
    output = tmp_path / 'process.SVG'
    assert rendered('reference_process', '--trees', TREES, '-o', output) == 0
    assert output.read_bytes() == (TREES / 'reference_process.svg').read_bytes()


def test_a_line_has_no_dot_text(tmp_path: Path) -> None:
    with pytest.raises(WrongUse, match=r'^x\.dot: a line is drawn as \.svg, .*--view tree'):
        run(arguments('x', '-o', tmp_path / 'x.dot'))


def test_tree_view_renders_without_dot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('PATH', '/nowhere')
    output = tmp_path / 'tree.dot'
    assert rendered(TREES / 'reference_process.yaml', '--view', 'tree', '-o', output) == 0
    assert 'all turns complete' in output.read_text()


def test_a_script_that_gets_stuck_is_drawn(tmp_path: Path) -> None:
    output = tmp_path / 'stuck.svg'
    assert rendered(STUCK, '-o', output) == 0
    assert 'read_before_assemble' in output.read_text()


@pytest.mark.parametrize(
    ('name', 'message'), [('x.gif', 'x.gif has the ending .gif'), ('x', 'x has no ending')]
)
def test_an_ending_that_names_no_format(name: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(WrongUse) as wrong:
        rendered(STUCK, '-o', tmp_path / name)
    assert str(wrong.value) == f'{message}; expected one of .svg, .png, .pdf, .dot'
    assert list(tmp_path.iterdir()) == []


def test_mistakes_are_told_and_nothing_is_written(tmp_path: Path) -> None:
    bad = tmp_path / 'bad.yaml'
    bad.write_text(STUCK.read_text().replace('TASK_A', 'TASKA'))
    with pytest.raises(Refused) as refused:
        rendered(bad, '-o', tmp_path / 'bad.svg')
    assert len(refused.value.findings) == 2
    assert not (tmp_path / 'bad.svg').exists()


def test_a_file_that_cannot_be_written(tmp_path: Path) -> None:
    with pytest.raises(CannotWrite, match=r'^cannot write .*: No such file or .*; check the path'):
        rendered(STUCK, '-o', tmp_path / 'nowhere' / 'x.svg')


# --- with a state -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ('words', 'what'),
    [
        (('--every', '1'), '--every is for --live'),
        (('--live', '--view', 'tree'), '--view tree shows no state'),
    ],
)
def test_options_that_mean_nothing_together(
    words: tuple[str, ...], what: str, tmp_path: Path
) -> None:
    with pytest.raises(WrongUse, match=what):
        run(arguments('x', '-o', tmp_path / 'x.svg', *words))


def test_drawn_status_replaces_output_file_atomically(tmp_path: Path) -> None:
    saved, output = tmp_path / 'status.json', tmp_path / 'x.svg'
    saved.write_text(json.dumps(to_plain(EMPTY, whole=True)))
    output.write_text('old')
    before = output.stat().st_ino
    assert rendered('reference_process', '--trees', TREES, '-o', output, '--status', saved) == 0
    assert 'Stopped, the belt rests, after event 0' in output.read_text()
    assert output.stat().st_ino != before
    assert sorted(path.name for path in tmp_path.iterdir()) == ['status.json', 'x.svg']


@pytest.mark.parametrize(
    ('content', 'message'),
    [
        (None, 'this is a pipe or a device, and no ordinary file'),
        ('[' * 100_000, 'is not JSON: '),
        ('\xff', 'is not JSON: '),
        ('{"cell": []}', 'holds no status of a cell'),
        ('[]', 'holds no status of a cell'),
    ],
)
def test_a_file_that_is_no_status_is_told(
    content: str | None, message: str, tmp_path: Path
) -> None:
    saved = tmp_path / 'status.json'
    os.mkfifo(saved) if content is None else saved.write_bytes(content.encode('latin-1'))
    with pytest.raises(CannotRead, match=message):
        rendered(
            'reference_process', '--trees', TREES, '-o', tmp_path / 'x.svg', '--status', saved
        )


EMPTY = CellStatus('reference_cell', 0.0, 0, '', PackmlState.STOPPED, 0.0)
