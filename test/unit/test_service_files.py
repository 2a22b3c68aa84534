"""The unit files for systemd: accepted by it, and by the program that they start."""

from __future__ import annotations

import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from bt_orchestrator.cli.verbs import command_of

UNITS = sorted((Path(__file__).parents[2] / 'config' / 'systemd').glob('*.service'))
PROGRAM = '/opt/bt_orchestrator/bin/bt-orchestrator'


def lines(unit: Path, key: str) -> list[str]:
    unit_lines = unit.read_text(encoding='utf-8').splitlines()
    return [line.partition('=')[2] for line in unit_lines if line.startswith(f'{key}=')]


def hardening(unit: Path) -> list[str]:
    return (
        unit.read_text(encoding='utf-8').partition('# What the service may not do.')[2].split('\n')
    )


@pytest.mark.skipif(shutil.which('systemd-analyze') is None, reason='this machine has no systemd')
def test_systemd_accepts_them(tmp_path: Path) -> None:
    for unit in UNITS:
        text = unit.read_text(encoding='utf-8').replace(PROGRAM, sys.executable)
        (tmp_path / unit.name).write_text(text, encoding='utf-8')
    names = [str(tmp_path / unit.name.replace('@', '@cell')) for unit in UNITS]
    done = subprocess.run(
        ['systemd-analyze', 'verify', '--man=no', *names],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.stdout + done.stderr, done.returncode) == ('', 0)


@pytest.mark.parametrize('unit', UNITS, ids=lambda unit: unit.stem)
def test_their_command_lines_are_read_by_the_program(unit: Path) -> None:
    (line,) = lines(unit, 'ExecStart')
    line = line.replace('${JOURNAL}', 'postgresql://line@db.plant/plant/line_1')
    program, *words = (word for word in shlex.split(line) if not word.startswith('$'))
    assert program == PROGRAM
    command = command_of(words)
    command.parser().parse_args(command.rest)


def test_they_are_hardened_alike() -> None:
    assert len(UNITS) == 4
    assert all(hardening(unit) == hardening(UNITS[0]) for unit in UNITS)
    assert 'ProtectSystem=strict' in hardening(UNITS[0])
