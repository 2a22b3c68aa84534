"""Which goal a fault strikes at."""

from __future__ import annotations

import pytest

from bt_orchestrator.model.fault import FaultKind, parse_fault
from bt_orchestrator.sim.faults import FaultSchedule


def struck(spec: str, tasks: str) -> list[int]:
    """Return the numbers of the goals, from 1, at which a fault strikes."""
    schedule = FaultSchedule([parse_fault(spec)])
    return [n for n, task in enumerate(tasks.split(), 1) if schedule.next_goal(task).faults]


@pytest.mark.parametrize(
    ('spec', 'goals'),
    [
        ('=abort', [1]),
        ('#3=abort', [3]),
        ('#*=abort', [1, 2, 3, 4, 5]),
        ('B=abort', [2]),
        ('B#2=abort', [4]),
        ('B#*=abort', [2, 4, 5]),
        ('C=abort', []),
        ('#0=not_ready', []),
    ],
)
def test_fault_counts_goals_of_component_or_task(spec: str, goals: list[int]) -> None:
    assert struck(spec, 'A B A B B') == goals


def test_first_listed_of_two_kinds_is_found() -> None:
    faults = [parse_fault(spec) for spec in ('=late:2.5', '=abort', '=hang')]

    goal = FaultSchedule(faults).next_goal('A')

    assert goal.find(FaultKind.HANG, FaultKind.ABORT) is faults[1]
    assert goal.late_s == 2.5


def test_goal_without_faults_succeeds_in_time() -> None:
    goal = FaultSchedule([]).next_goal('A')

    assert goal.find(*FaultKind) is None
    assert goal.late_s == 0.0


def test_initial_faults_are_separate_from_goal_faults() -> None:
    schedule = FaultSchedule([parse_fault('=not_ready:3'), parse_fault('#0=not_ready:5')])

    at_start = schedule.at_start(FaultKind.NOT_READY)

    assert at_start is not None
    assert at_start.seconds == 5
    assert schedule.at_start(FaultKind.SILENT) is None
