"""The report of a campaign, and the plan that it is about."""

from __future__ import annotations

import random

from chaos.crashing_node import POINTS
from chaos.line import REMEMBERED_S
from chaos.plan import SHARES, STRIKES, Shot, draw, draw_with_database, forgotten, parts
from chaos.tally import Tally, lines

SHOTS = [Shot('landed'), Shot('sent'), Shot('orchestrator')]


def test_planned_point_without_kill_is_fault() -> None:
    tally = Tally()
    tally.plan(SHOTS)
    tally.kills.update(['landed', 'orchestrator'])
    assert tally.points_without_kill == ['sent']
    assert tally.faults == ['nobody was killed at sent']
    tally.kills['sent'] += 1
    assert tally.faults == []


def test_points_are_judged_over_all_parts() -> None:
    total, other = Tally(), Tally()
    total.plan(SHOTS)
    other.plan(SHOTS)
    other.kills.update(['landed', 'sent'])
    total.add(other)
    assert total.points_without_kill == []


def test_every_fault_is_in_the_report() -> None:
    total = Tally()
    for name, faults in vars(total.verdict).items():
        faults.append(f'a fault of {name}')
    report = list(lines(total))
    for name in vars(total.verdict):
        assert f'a fault of {name}' in report
        assert f'{name.replace("_", " ")} 1' in '\n'.join(report)


def test_plan_covers_each_point_and_restart_kind() -> None:
    shots = list(draw(random.Random(1), 40))
    ours = [shot for shot in shots if shot.target not in SHARES]
    assert len(ours) >= 40
    assert {shot.target for shot in shots} >= {*POINTS, 'orchestrator', 'both', *SHARES}
    assert {shot.restart.auto_resume for shot in ours} == {True, False}
    steps = [shot.restart.clock_step_s for shot in ours]
    assert min(steps) < -60.0 < -1.0 < 0.0 < max(steps)


def test_forgotten_exceeds_server_memory_despite_wall_clock() -> None:
    restart = forgotten(random.Random(1))
    assert restart.away_s > REMEMBERED_S
    assert restart.away_s + restart.clock_step_s < 0.0


def test_parts_split_plan_evenly_and_completely() -> None:
    shots = list(draw(random.Random(1), 45))
    groups = list(parts(shots, 20))
    assert [shot for part in groups for shot in part] == shots
    counts = [sum(shot.target not in SHARES for shot in part) for part in groups]
    assert counts[:-1] == [20] * len(counts[:-1])
    assert 0 < counts[-1] <= 20


def test_database_plan_has_requested_kills_and_stops() -> None:
    strikes = {strike: number for number, strike in enumerate(STRIKES, 1)}
    shots = list(draw_with_database(random.Random(1), 20, 12, strikes))
    assert {name: sum(shot.target == name for shot in shots) for name in STRIKES} == strikes
    assert sum(shot.kills for shot in shots) == 20
    stopped = [shot for shot in shots if shot.stopped_s]
    assert {shot.target for shot in stopped} == set(POINTS)
    assert len(stopped) == 12
    tally = Tally()
    tally.plan(shots)
    assert tally.planned.total() == 20
