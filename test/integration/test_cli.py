"""The program itself, in a process of its own, on the shipped files."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from fakes.shipped import REFERENCE_CELL, REFERENCE_ORDER, STUCK, TREES
from patience import PATIENCE_S

from bt_orchestrator.model.codec import from_record

CELL = ('--cell', str(REFERENCE_CELL))
SHIPPED = TREES / 'reference_process.yaml'


def program(*words: str | Path, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, '-m', 'bt_orchestrator', *map(str, words)],
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        cwd=cwd,
        check=False,
    )


@pytest.mark.parametrize('script', ['reference_process', 'inspect_and_assemble'])
def test_the_shipped_scripts_fit_the_shipped_cell(script: str, tmp_path: Path) -> None:
    by_path = program('check', TREES / f'{script}.yaml', *CELL)
    by_name = program('check', script, *CELL, cwd=tmp_path)

    assert (by_path.returncode, by_path.stderr) == (0, '')
    summary, pace, *_ = by_path.stdout.splitlines()
    assert summary.startswith(f'{script}: ')
    assert summary.endswith('fits cell reference_cell')
    assert pace.startswith('  pace: ')
    assert (by_name.returncode, by_name.stdout) == (0, by_path.stdout)


def test_trees_in_the_working_directory_come_first(tmp_path: Path) -> None:
    (tmp_path / 'trees').mkdir()
    (tmp_path / 'trees' / 'reference_process.yaml').write_text(STUCK.read_text())
    done = program('check', 'reference_process', *CELL, cwd=tmp_path)

    assert (done.returncode, done.stderr.split(':')[0]) == (1, 'trees/reference_process.yaml')
    assert 'the line gets stuck with stuck' in done.stderr


def test_a_bad_script_is_refused_with_places(tmp_path: Path) -> None:
    bad = tmp_path / 'bad.yaml'
    bad.write_text(STUCK.read_text().replace('PICK_AND_PACK', 'PICK_AND_PAK'))
    done = program('check', bad, *CELL)

    assert (done.returncode, done.stdout) == (1, '')
    (line,) = done.stderr.splitlines()
    assert line.startswith(f'{bad}:12:')
    assert 'did you mean `PICK_AND_PACK`?' in line


@pytest.mark.parametrize('json_option', [(), ('--json',)])
@pytest.mark.parametrize(
    'content', [None, b'\x7fELF\x02\x01\x01\x00\xff\xfe', b'', b'{', b'a: &x [*x]\n']
)
def test_no_file_ends_in_a_traceback(
    content: bytes | None, json_option: tuple[str, ...], tmp_path: Path
) -> None:
    path = tmp_path / 'file.yaml'
    if content is not None:
        path.write_bytes(content)
    runs = [
        program('check', path, *CELL, *json_option),
        program('check', STUCK, '--cell', path, *json_option),
        program('simulate', path, *CELL, *json_option),
    ]

    for done in runs:
        assert done.returncode == 1
        assert 'Traceback' not in done.stderr
        if json_option:
            assert json.loads(done.stdout)['ok'] is False
        else:
            assert f'{path}:1:' in done.stderr


def test_wrong_use() -> None:
    done = program('check', STUCK)

    assert done.returncode == 2
    assert '--cell' in done.stderr


def test_checking_does_not_need_rclpy() -> None:
    code = (
        'import sys; from bt_orchestrator.cli.main import main; '
        f'status = main(["check", {str(SHIPPED)!r}, "--cell", {str(REFERENCE_CELL)!r}]); '
        'sys.exit(3 if "rclpy" in sys.modules else status)'
    )
    done = subprocess.run([sys.executable, '-c', code], timeout=PATIENCE_S, check=False)

    assert done.returncode == 0


def test_the_shipped_order_is_predicted() -> None:
    done = program('simulate', REFERENCE_ORDER, *CELL, '--trees', TREES, '--json')

    assert (done.returncode, done.stderr) == (0, '')
    (job,) = json.loads(done.stdout)['forecast']['jobs']
    assert (job['job'], job['packed'], job['finished_s']) == ('WO-1001', 3, 39.0)


def test_stuck_line_names_cycle_and_writes_full_trace(tmp_path: Path) -> None:
    order = tmp_path / 'order.yaml'
    order.write_text(f'script: {STUCK}\nquantity: 10\n')
    trace = tmp_path / 'trace.jsonl'
    done = program('simulate', order, *CELL, '--trace', trace)

    assert done.returncode == 1
    assert 'section 2: waiting for assemble to take flag read_before_assemble' in done.stdout
    records = [json.loads(line) for line in trace.read_text().splitlines()]
    assert [record['seq'] for record in records] == list(range(1, len(records) + 1))
    assert records[-1]['time'] == 9.0
    for record in records:
        from_record(record)


def test_a_reader_that_leaves_is_no_error() -> None:
    read_end, write_end = os.pipe()
    os.close(read_end)
    done = subprocess.run(
        [sys.executable, '-m', 'bt_orchestrator', 'check', str(SHIPPED), *CELL],
        stdout=write_end,
        stderr=subprocess.PIPE,
        text=True,
        timeout=PATIENCE_S,
        check=False,
    )
    os.close(write_end)

    assert (done.returncode, done.stderr) == (141, '')
