"""The core without one of its extensions: a blocker hides it from every process of the test."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from ros_domain import discover_fast

from bt_orchestrator.base.extending import EXTENSIONS, Extension

SCISSORS = Path(__file__).parents[1] / 'scissors'
CORE = ('test/unit/rules/test_3_belt.py', 'test/unit/model/test_fold.py')
LONGEST_S = 150


@pytest.mark.parametrize('extension', EXTENSIONS, ids=lambda add_on: add_on.name)
def test_the_core_works_without(extension: Extension, tmp_path: Path) -> None:
    """Check, render, simulate, run, watch, history; its verbs answer with what to install."""
    path = [str(SCISSORS / 'blocker'), os.environ.get('PYTHONPATH', '')]
    environment = {
        **os.environ,
        'WITHOUT': ' '.join([extension.room, *extension.packages]),
        'PYTHONPATH': os.pathsep.join(filter(None, path)),
        'ROS_LOG_DIR': str(tmp_path / 'log'),
        'XDG_STATE_HOME': str(tmp_path),
    }
    discover_fast(environment)
    command = [sys.executable, str(SCISSORS / 'core_alone.py'), extension.name, str(tmp_path)]
    ended = subprocess.run(
        [*command, *CORE],
        env=environment,
        timeout=LONGEST_S,
        check=False,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    assert ended.returncode == 0, ended.stdout
