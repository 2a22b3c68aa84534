"""Attacked by everything that a peer can do, a line loses nothing and does nothing twice.

The short form of `scripts/attack`; its times are for a quiet machine, and fail nothing here.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

TEST = Path(__file__).parents[1]


@pytest.mark.long
@pytest.mark.timeout(600)
def test_9_1_attacks_lose_and_repeat_nothing(tmp_path: Path) -> None:
    file = tmp_path / 'figures.json'
    done = subprocess.run(
        [sys.executable, '-m', 'attack', '--short', '--json', file, '--keep', tmp_path / 'kept'],
        env={**os.environ, 'PYTHONPATH': str(TEST)},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    figures = json.loads(file.read_text())
    assert figures['all_faults'] == []
    assert figures['orders'] > 1
    assert all(phase['tasks'] for phase in figures['phases'])
