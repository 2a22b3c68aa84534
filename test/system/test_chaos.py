"""Killed at every step of a settle and with its controllers, a cell loses and repeats nothing.

The short form of `scripts/chaos`.
"""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from chaos.campaign import Campaign
from chaos.crashing_node import POINTS
from chaos.plan import BOTH, Restart, Shot, forgotten

BACK = Restart(clock_step_s=-120.0, auto_resume=False)


@pytest.mark.long
@pytest.mark.timeout(600)
def test_9_2_killed_at_every_step_nothing_is_lost_and_nothing_done_twice(tmp_path: Path) -> None:
    restarts = [Restart(), BACK, forgotten(random.Random(7)), Restart(clock_step_s=60.0)]
    restarts += [Restart()] * (len(POINTS) - len(restarts))
    shots = [Shot(*each) for each in zip([*POINTS, BOTH], [*restarts, BACK], strict=True)]
    tally = Campaign(tmp_path, seed=7, items=3, shots=shots).run()
    assert tally.faults == []
    assert tally.orchestrator_kills == len(shots)
    assert tally.figures['copies after a crash'] > 0
