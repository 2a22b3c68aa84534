"""Killed at every step of a settle and with its controllers, a cell loses and repeats nothing.

Nor does it if its database is struck. These are the short forms of `scripts/chaos`.
"""

from __future__ import annotations

import random
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from chaos import traps
from chaos.campaign import Campaign
from chaos.crashing_node import POINTS
from chaos.database import Database
from chaos.operator import Operator
from chaos.plan import BOTH, STRIKES, Restart, Shot, forgotten
from chaos.standby import Succession

BACK = Restart(clock_step_s=-120.0, auto_resume=False)


@pytest.mark.long
@pytest.mark.timeout(600)
def test_9_2_kills_at_every_step_lose_and_repeat_nothing(tmp_path: Path) -> None:
    restarts = [Restart(), BACK, forgotten(random.Random(7)), Restart(clock_step_s=60.0)]
    restarts += [Restart()] * (len(POINTS) - len(restarts))
    shots = [Shot(*each) for each in zip([*POINTS, BOTH], [*restarts, BACK], strict=True)]
    tally = Campaign(tmp_path, seed=7, items=3, shots=shots).run()
    assert tally.faults == []
    assert tally.orchestrator_kills == len(shots)
    assert tally.figures['copies after a crash'] > 0


@pytest.mark.long
@pytest.mark.timeout(300)
def test_9_1_database_faults_lose_and_repeat_nothing(
    tmp_path: Path,
) -> None:
    pytest.importorskip('psycopg', reason='needs psycopg: ./scripts/bootstrap --postgres')
    strikes = [strike for strike in STRIKES if strike != 'promotion']
    shots = [Shot('committed'), Shot('committed', stopped_s=0.5), *map(Shot, strikes)]
    tally = Campaign(tmp_path, seed=34, items=3, shots=shots, database=Database()).run()
    assert tally.faults == []
    assert tally.orchestrator_kills == tally.figures['stops'] == 1
    assert {strike: tally.figures[strike] for strike in strikes} == dict.fromkeys(strikes, 1)
    assert tally.figures['ended by itself'] == 0, 'a server that comes back ends no node'


@pytest.mark.long
@pytest.mark.timeout(300)
def test_9_1_after_crash_only_replicated_data_counts_as_kept(
    tmp_path: Path,
) -> None:
    pytest.importorskip('psycopg', reason='needs psycopg: ./scripts/bootstrap --postgres')
    assert traps.rounds(tmp_path, traps.TRAPS[0], 1, checked=True) == [[]]


@pytest.mark.long
@pytest.mark.timeout(300)
def test_9_4_standby_replaces_killed_and_stopped_leaders(tmp_path: Path) -> None:
    pytest.importorskip('psycopg', reason='needs psycopg: ./scripts/bootstrap --postgres')
    counts = Succession(tmp_path, seed=94, items=4, kills=3, stops=1).run()
    assert counts.verdict.faults == []
    assert (counts.kills, counts.stops) == (3, 1)


def test_operator_at_another_terminal_gets_time_to_hear(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr('chaos.operator._QUIET_S', 0.5)
    nothing: Any = SimpleNamespace(statuses=[])
    operator = Operator(nothing, 'small', 1, tmp_path / 'none', tmp_path / 'none')
    until = time.monotonic() + 60.0
    while not operator.is_cut_off(node_lives=True):
        assert time.monotonic() < until
    operator.forget()
    assert not operator.is_cut_off(node_lives=True)
