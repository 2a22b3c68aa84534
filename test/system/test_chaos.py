"""Killed at every step of a settle and with its controllers, a cell loses and repeats nothing.

The short form of `scripts/chaos`.
"""

from __future__ import annotations

from pathlib import Path

from chaos.campaign import BOTH, Campaign
from chaos.crashing_node import POINTS


def test_9_2_killed_at_every_step_nothing_is_lost_and_nothing_done_twice(tmp_path: Path) -> None:
    tally = Campaign(tmp_path, seed=7, items=4, kills=[*POINTS, BOTH]).run()
    assert tally.verdict.faults == []
    assert tally.orchestrator_kills >= len(POINTS) / 2, 'the job ended before it was shot at'
