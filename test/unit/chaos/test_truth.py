"""The judge of the chaos test sees what went wrong."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from chaos.line import REMEMBERED_S
from chaos.truth import Clocks, Controllers, Verdict, attempts, judge

from bt_orchestrator.model import events as e

KEY: dict[str, Any] = {'job': 'J', 'section': 1, 'item': 'J/1', 'task': 'feed'}
PLACED = e.ItemPlaced(job='J', item='J/1', section=1)
PACKED = e.ItemRemoved(job='J', item='J/1', section=1, how='packed')


def started(goal: str = 'g1', attempt: int = 1) -> e.Event:
    return e.TaskStarted(
        **KEY, name='TASK_A', action='feeder/task', component='feeder', attempt=attempt, goal=goal
    )


def succeeded(goal: str = 'g1') -> e.Event:
    return e.TaskSucceeded(**KEY, attempt=1, goal=goal, results={})


def in_doubt(time: float) -> e.Event:
    return e.TaskFailed(**KEY, attempt=1, goal='g1', reason='in_doubt', message='', time=time)


def answered(answer: str) -> list[e.Event]:
    return [
        e.HoldRaised(hold='1', **KEY, reason='in_doubt'),
        e.OperatorDecided(hold='1', answer=answer, who='A', reason=''),
    ]


def verdict(
    tmp_path: Path,
    events: Sequence[e.Event],
    *records: tuple[str, str],
    killed_at: float | None = None,
    status: str = 'succeeded',
    **known: Any,
) -> Verdict:
    log = tmp_path / 'goals.jsonl'
    lines = [
        json.dumps({'time': float(n), 'event': event, 'goal': goal, 'status': status})
        for n, (event, goal) in enumerate(records)
    ]
    log.write_text('\n'.join(lines))
    killed = {} if killed_at is None else {'feeder': [killed_at]}
    return judge(events, Controllers(log), killed, **known)


GOOD = (('accepted', 'g1'), ('started', 'g1'), ('ended', 'g1'))


def test_a_good_run_has_no_faults(tmp_path: Path) -> None:
    assert verdict(tmp_path, [started(), succeeded(), PLACED, PACKED], *GOOD).faults == []


def test_a_task_done_twice(tmp_path: Path) -> None:
    events = [started(), started('g2', 2), succeeded('g2'), PLACED, PACKED]
    done = (*GOOD, ('started', 'g2'), ('ended', 'g2'))
    assert len(verdict(tmp_path, events, *done).twice) == 1
    assert verdict(tmp_path, [*events, *answered('retry')], *done).twice == []


def test_a_goal_executed_twice(tmp_path: Path) -> None:
    result = verdict(tmp_path, [started(), succeeded(), *answered('retry')], *GOOD, *GOOD)
    assert result.twice == ['goal g1 was executed more than once']


def test_goal_only_client_heard_counts_as_repeat(tmp_path: Path) -> None:
    events = [started('g2'), succeeded('g2'), PLACED, PACKED]
    done = (*GOOD, ('started', 'g2'), ('ended', 'g2'))
    assert len(verdict(tmp_path, events, *done, heard=[started()]).twice) == 1
    assert verdict(tmp_path, events, *done, heard=[started('g2')]).twice == []


def test_a_task_that_a_killed_controller_began_counts(tmp_path: Path) -> None:
    events = [started(), started('g2', 2), succeeded('g2')]
    done = (*GOOD[:2], ('started', 'g2'), ('ended', 'g2'))
    assert len(verdict(tmp_path, events, *done, killed_at=1.5).twice) == 1
    assert verdict(tmp_path, [*events, *answered('retry')], *done, killed_at=1.5).twice == []


def move(goal: str) -> e.Event:
    return e.TaskStarted(
        task=e.INDEX_KEY.task, name='MOVE', action='index', component='belt', attempt=1, goal=goal
    )


def test_a_move_of_the_belt_done_twice(tmp_path: Path) -> None:
    moved = [move('g1'), e.BeltIndexed(beat=2), move('g2'), e.BeltIndexed(beat=3)]
    done = (*GOOD, ('started', 'g2'), ('ended', 'g2'))
    assert verdict(tmp_path, moved, *done).twice == []
    assert len(verdict(tmp_path, [*moved[::2], *moved[1::2]], *done).twice) == 1
    assert [len(goals) for goals in attempts(moved).values()] == [1, 1]


def test_a_task_that_was_never_executed(tmp_path: Path) -> None:
    assert len(verdict(tmp_path, [started()]).lost) == 1
    assert verdict(tmp_path, [started(), *answered('mark_done')]).lost == []


def test_an_item_that_never_left(tmp_path: Path) -> None:
    assert verdict(tmp_path, [started(), PLACED], *GOOD).lost == ['J/1 left the line 0 times']


def test_a_success_that_the_controller_does_not_know(tmp_path: Path) -> None:
    assert len(verdict(tmp_path, [started(), succeeded()], *GOOD[:2]).untrue) == 1


def test_a_goal_that_the_journal_does_not_know(tmp_path: Path) -> None:
    assert len(verdict(tmp_path, [started(), succeeded()], *GOOD, ('accepted', 'g9')).untrue) == 1


def test_doubt_about_what_the_controller_knew(tmp_path: Path) -> None:
    known_until = 2.0 + REMEMBERED_S
    events = [started(), in_doubt(time=known_until - 0.1)]
    assert len(verdict(tmp_path, events, *GOOD).needless_doubt) == 1
    events = [started(), in_doubt(time=known_until + 0.1)]
    assert verdict(tmp_path, events, *GOOD).needless_doubt == []


@pytest.mark.parametrize(('seq', 'ahead_s'), [(7, 500.0), (8, -100.0)])
def test_doubt_is_judged_by_real_time(tmp_path: Path, seq: int, ahead_s: float) -> None:
    file = tmp_path / 'clocks.jsonl'
    records = [{'after_seq': 0, 'ahead_s': 500.0}, {'after_seq': 7, 'ahead_s': -100.0}]
    file.write_text('\n'.join(map(json.dumps, records)))
    known_until = 2.0 + REMEMBERED_S + ahead_s
    for late_s, count in ((-0.1, 1), (0.1, 0)):
        doubt = in_doubt(time=0.0).stamped(seq, known_until + late_s)
        result = verdict(tmp_path, [started(), doubt], *GOOD, clocks=Clocks(file))
        assert len(result.needless_doubt) == count


def test_doubt_about_a_killed_controller(tmp_path: Path) -> None:
    events = [started(), in_doubt(time=5.0)]
    assert verdict(tmp_path, events, *GOOD[:2], killed_at=2.0).needless_doubt == []
    assert len(verdict(tmp_path, events, *GOOD[:2], killed_at=-1.0).needless_doubt) == 1


def test_doubt_about_what_was_cancelled_is_not_needless(tmp_path: Path) -> None:
    """The controller knew that it was, and nobody how far it came (semantics 2.6)."""
    events = [started(), in_doubt(time=2.1)]
    assert verdict(tmp_path, events, *GOOD, status='canceled').needless_doubt == []
    assert len(verdict(tmp_path, events, *GOOD, status='aborted').needless_doubt) == 1
