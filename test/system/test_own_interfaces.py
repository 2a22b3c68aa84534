"""A user's own action package, from its .action file to goals that the node sends."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from cell_processes import ROOT, SMALL_CELL, StartCell

pytestmark = pytest.mark.every_distro

PACKAGE = ROOT / 'test' / 'data' / 'drill_interfaces'

CELL = (
    SMALL_CELL
    + """
  drill:
    section: 2
    action: drill/drill
    type: drill_interfaces/action/Drill
    durations: {DRILL: 1.0, HOME: 1.0}
    results: {DRILL: {measured_mm: 11.5}}
"""
)

SCRIPT = """
script: drilled
sections:
  1:
    - {id: feed, task: TASK_A, action: feeder/task, qty_change: 1}
  2:
    - {id: hole, task: DRILL, action: drill/drill, args: {depth_mm: 12.5}}
    - {id: pack, task: TASK_A, action: packer/task, qty_change: -1}
"""


def build(sources: Path, wheels: Path) -> Path:
    """Build the wheel as `scripts/bootstrap --interfaces` does."""
    command = [sys.executable, '-m', 'rosidl_pip', str(sources), str(wheels)]
    builder = {**os.environ, 'PYTHONPATH': str(ROOT / 'interfaces')}
    subprocess.run(command, env=builder, check=True, capture_output=True)
    (wheel,) = wheels.glob('drill_interfaces-*.whl')
    return wheel


def install(wheel: Path, prefix: Path) -> None:
    """Lay the wheel out in a prefix of its own, an overlay of this environment."""
    pip = [sys.executable, '-m', 'pip', 'install', '--quiet', '--no-deps', '--no-index']
    subprocess.run([*pip, '--prefix', str(prefix), str(wheel)], check=True)


@pytest.mark.skipif(
    not Path(sys.prefix, 'bootstrap').is_dir(),
    reason='the builder works in the environment of scripts/bootstrap',
)
def test_user_defined_action_package_takes_part(
    start_cell: StartCell, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sources, wheels, overlay = (tmp_path / name for name in ('sources', 'wheels', 'overlay'))
    (sources / 'action').mkdir(parents=True)
    for file in ('package.xml', 'CMakeLists.txt', 'action/Drill.action'):
        (sources / file).write_bytes((PACKAGE / file).read_bytes())
    wheels.mkdir()
    install(build(sources, wheels), overlay)
    (site_packages,) = overlay.glob('lib/python*/site-packages')
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(overlay), prepend=os.pathsep)
    monkeypatch.setenv('PYTHONPATH', str(site_packages), prepend=os.pathsep)

    cell = start_cell(CELL)
    cell.connect()
    cell.watch.submit(cell.script(SCRIPT, 'drilled'), quantity=1)
    job = cell.watch.until_ended('WO-1')
    assert (job.packed, job.nonconforming) == (1, 0)
    assert cell.watch.until('task.started', task='hole')['args'] == {'depth_mm': 12.5}
    done = cell.watch.until('task.succeeded', task='hole')
    assert done['results']['measured_mm'] == 11.5
    cell.stop()
