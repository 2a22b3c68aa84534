"""The examples of docs/mes.md, as they stand there."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest
from cell_processes import ROOT, small_script
from opcua.conftest import StartLine
from opcua.driver import node_program, node_variables
from opcua.line import Line
from patience import PATIENCE_S
from served_process import PASSWORD

EXAMPLES = ROOT / 'docs' / 'examples'
KEPT = ROOT / 'test' / 'data' / 'release_0_1_0' / 'programs'
"""The examples of the last version, which clients were written after."""

RUN_BY: Mapping[str, Callable[[], str]] = {
    'mes_order.js': node_program,
    'mes_order.py': lambda: sys.executable,
}


def examples() -> list[Path]:
    """Return the examples of today, and those of the last version that say something else."""
    today = [EXAMPLES / name for name in RUN_BY]
    kept = [KEPT / name for name in RUN_BY]
    changed = [old for old, new in zip(kept, today, strict=True) if differ(old, new)]
    return [*today, *changed]


def differ(first: Path, other: Path) -> bool:
    return first.read_text(encoding='utf-8') != other.read_text(encoding='utf-8')


DONE = """\
StoreAndStart: 1
{0}: AllowedToStart
{0}: Running
{0}: Ended
RequestJobResponseByJobOrderID: 1
GoodQuantity: 2
ScrapQuantity: 0
Clear: 1
"""


@pytest.mark.parametrize('file', examples(), ids=lambda file: f'{file.parent.name}-{file.name}')
@pytest.mark.long
def test_example_works_once_its_certificate_is_trusted(
    start_line: StartLine, tmp_path: Path, file: Path
) -> None:
    line = start_line()
    line.cell.script(small_script())
    command = [RUN_BY[file.name](), str(file), line.server.endpoint, 'mes']
    status, _, _ = _run([*command, 'WO-1', 'small', '2'], tmp_path)
    assert status != 0  # nobody trusts its certificate yet
    line.server.trust(_refused(line))
    status, output, errors = _run([*command, 'WO-1', 'small', '2'], tmp_path)
    assert status == 0, output + errors
    # What an event tells may come before the answer to the call that caused it.
    assert sorted(output.splitlines()) == sorted(DONE.format('WO-1').splitlines()), errors
    status, output, _ = _run([*command, 'WO-2', 'no_such_script', '2'], tmp_path)
    assert (status != 0, output) == (True, 'StoreAndStart: 16\n')


def _run(command: list[str], folder: Path) -> tuple[int, str, str]:
    variables = {
        **node_variables(),
        'OPCUA_PASSWORD': PASSWORD,
        'OPCUA_PKI': str(folder / 'example_pki'),
    }
    done = subprocess.run(
        command,
        cwd=folder,
        env={**os.environ, **variables},
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
    )
    return done.returncode, done.stdout, done.stderr


def _refused(line: Line) -> str:
    """Return the thumbprint that the list of refused certificates begins with."""
    words = line.server.trust().split()
    return next(word for word in words if len(word) >= 8 and set(word) <= set('0123456789abcdef'))
