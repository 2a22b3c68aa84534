"""What the controllers did, and whether it is what the journal says."""

from __future__ import annotations

import json
import sqlite3
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import from_record


def journal(path: Path) -> list[e.Event]:
    """Return what a journal says now, whoever writes it."""
    with closing(sqlite3.connect(f'file:{path}?mode=ro', uri=True)) as database:
        rows = database.execute('SELECT record FROM events ORDER BY seq').fetchall()
    return [from_record(json.loads(record)) for (record,) in rows]


REMEMBERED_S = 10.0
"""Seconds for which the simulated controllers remember a goal that ended."""


class Controllers:
    """The story of each goal, told by the simulated controllers themselves."""

    def __init__(self, log: Path) -> None:
        lines = log.read_text().splitlines() if log.exists() else []
        self.records: list[Mapping[str, Any]] = [json.loads(line) for line in lines]
        self.by_goal: dict[str, list[Mapping[str, Any]]] = defaultdict(list)
        for record in self.records:
            if 'goal' in record:
                self.by_goal[record['goal']].append(record)

    def executions(self, goal: str) -> int:
        """Count how often the work of a goal was begun."""
        return sum(record['event'] == 'started' for record in self.by_goal.get(goal, ()))

    def succeeded(self, goal: str) -> bool:
        """Tell whether the work of a goal came to a good end."""
        return any(
            record['event'] == 'ended' and record['status'].lower() == 'succeeded'
            for record in self.by_goal.get(goal, ())
        )

    def time_of(self, goal: str, event: str) -> float | None:
        """Return when something happened to a goal first."""
        found = (r['time'] for r in self.by_goal.get(goal, ()) if r['event'] == event)
        return next(found, None)


@dataclass
class Verdict:
    """What must not be, in words; all empty after a good run."""

    lost: list[str] = field(default_factory=list)
    twice: list[str] = field(default_factory=list)
    stuck: list[str] = field(default_factory=list)
    """Left behind by whoever ran the line."""
    untrue: list[str] = field(default_factory=list)
    """The journal says what the controllers do not."""
    needless_doubt: list[str] = field(default_factory=list)
    """`in_doubt` though the controller lived, had accepted, and still knew the end."""

    @property
    def faults(self) -> list[str]:
        """Everything, one sentence each."""
        return [*self.lost, *self.twice, *self.stuck, *self.untrue, *self.needless_doubt]


def judge(
    events: Sequence[e.Event], controllers: Controllers, killed: Mapping[str, Sequence[float]]
) -> Verdict:
    """Compare a journal with the log of its controllers.

    :param killed: by component, when its controller was killed, seconds since the epoch
    """
    verdict = Verdict()
    tasks = _attempts(events)
    for key, goals in tasks.items():
        _judge_task(key, goals, _Answers(events), controllers, verdict)
    _judge_goals(events, controllers, verdict)
    verdict.needless_doubt += _needless(events, controllers, killed)
    verdict.lost += _items_without_an_end(events)
    return verdict


def _attempts(events: Sequence[e.Event]) -> dict[e.TaskKey, list[str]]:
    """Return the goals of each task of an item; the belt's moves have no task of their own."""
    attempts: dict[e.TaskKey, list[str]] = defaultdict(list)
    for event in events:
        if isinstance(event, e.TaskStarted) and event.key != e.INDEX_KEY:
            attempts[event.key].append(event.goal)
    return attempts


class _Answers:
    """What the operator decided about each task."""

    def __init__(self, events: Sequence[e.Event]) -> None:
        held = {
            x.hold: e.TaskKey(x.job, x.section, x.item, x.task)
            for x in events
            if isinstance(x, e.HoldRaised) and x.task is not None
        }
        self._given = Counter(
            (held[x.hold], x.answer)
            for x in events
            if isinstance(x, e.OperatorDecided) and x.hold in held
        )

    def count(self, key: e.TaskKey, answer: str) -> int:
        """Count one answer about one task."""
        return self._given[key, answer]


def _judge_task(
    key: e.TaskKey,
    goals: Sequence[str],
    answers: _Answers,
    controllers: Controllers,
    verdict: Verdict,
) -> None:
    executed = sum(controllers.executions(goal) for goal in goals)
    if executed > 1 + answers.count(key, 'retry'):
        verdict.twice.append(f'{key} was executed {executed} times')
    if not executed and not answers.count(key, 'mark_done'):
        verdict.lost.append(f'{key} was never executed')


def _judge_goals(events: Sequence[e.Event], controllers: Controllers, verdict: Verdict) -> None:
    started = {x.goal for x in events if isinstance(x, e.TaskStarted)}
    for goal in controllers.by_goal:
        if controllers.executions(goal) > 1:
            verdict.twice.append(f'goal {goal} was executed more than once')
        if goal not in started:
            verdict.untrue.append(f'goal {goal} reached a controller and is not in the journal')
    for event in events:
        if isinstance(event, e.TaskSucceeded) and not controllers.succeeded(event.goal):
            verdict.untrue.append(f'{event.key}: succeeded, says the journal; its controller no')


def _items_without_an_end(events: Sequence[e.Event]) -> Iterator[str]:
    placed = {x.item for x in events if isinstance(x, e.ItemPlaced)}
    gone = Counter(x.item for x in events if isinstance(x, e.ItemRemoved))
    for item in sorted(placed):
        if gone[item] != 1:
            yield f'{item} left the line {gone[item]} times'


def _needless(
    events: Sequence[e.Event], controllers: Controllers, killed: Mapping[str, Sequence[float]]
) -> Iterator[str]:
    component = {x.goal: x.component for x in events if isinstance(x, e.TaskStarted)}
    for event in events:
        if not isinstance(event, e.TaskFailed) or event.reason != 'in_doubt' or not event.goal:
            continue
        accepted = controllers.time_of(event.goal, 'accepted')
        ended = controllers.time_of(event.goal, 'ended')
        if accepted is None or any(t > accepted for t in killed.get(component[event.goal], ())):
            continue
        if ended is None or event.time < ended + REMEMBERED_S:
            yield f'{event.key} in doubt, though its controller knew goal {event.goal}'
