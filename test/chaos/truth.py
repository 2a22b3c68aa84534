"""What the controllers did, and whether it is what the journal says."""

from __future__ import annotations

import json
import sqlite3
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from chaos.line import REMEMBERED_S

from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import from_record
from bt_orchestrator.model.goal import GoalStatus

Rows = list[tuple[int, str]]

Place = Path | Callable[[], Rows]
"""A journal: its file, or what reads it in a database."""


def rows(path: Place) -> Rows:
    """Return number and record of the events in a journal, whoever writes it; none: no file."""
    if not isinstance(path, Path):
        return path()
    if not path.exists():
        return []
    with closing(sqlite3.connect(f'file:{path}?mode=ro', uri=True)) as database:
        return database.execute('SELECT seq, record FROM events ORDER BY seq').fetchall()


def journal(path: Place) -> list[e.Event]:
    """Return the events of a journal as they are now."""
    return [from_record(json.loads(record)) for _, record in rows(path)]


class Work(NamedTuple):
    """What is to be done once: a task of an item, or one move of the belt."""

    key: e.TaskKey
    move: int = 0
    """How often the belt had moved before; 0 for whatever is no move."""

    def __str__(self) -> str:
        return f'{self.key} {self.move + 1}' if self.key == e.INDEX_KEY else str(self.key)


class Clocks:
    """How wrong the clock of each orchestrator was (`crashing_node.py`)."""

    def __init__(self, path: Path | None = None) -> None:
        lines = path.read_text().splitlines() if path and path.exists() else []
        self._ahead_s = {r['after_seq']: r['ahead_s'] for r in map(json.loads, lines)}

    def real_time(self, event: e.Event) -> float:
        """Return when something really happened, seconds since the epoch."""
        of = max((after for after in self._ahead_s if after < event.seq), default=None)
        return event.time - (0.0 if of is None else self._ahead_s[of])


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
        return self._ended(goal, GoalStatus.SUCCEEDED)

    def cancelled(self, goal: str) -> bool:
        """Tell whether the work of a goal was cut short, whoever asked for that."""
        return self._ended(goal, GoalStatus.CANCELED)

    def time_of(self, goal: str, event: str) -> float | None:
        """Return when something happened to a goal first."""
        times = (r['time'] for r in self.by_goal.get(goal, ()) if r['event'] == event)
        return next(times, None)

    def _ended(self, goal: str, status: GoalStatus) -> bool:
        return any(
            record['event'] == 'ended' and record['status'].lower() == status.value
            for record in self.by_goal.get(goal, ())
        )


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
    """`in_doubt` though the controller lived, had accepted, and still knew the end.

    An end that was cancelled says nothing: how far the work came is in doubt (semantics 2.6, 7.2).
    """
    vanished: list[str] = field(default_factory=list)
    """Somebody was told of events that are not in the journal."""
    misled: list[str] = field(default_factory=list)
    """A reader was told something twice, or not all of it, or was turned away."""
    bad_copies: list[str] = field(default_factory=list)
    """A backup is damaged, or is not how the journal begins."""

    @property
    def faults(self) -> list[str]:
        """Everything, one sentence each."""
        return [fault for group in vars(self).values() for fault in group]

    def add(self, other: Verdict) -> None:
        """Take in what was found elsewhere."""
        for name, faults in vars(other).items():
            getattr(self, name).extend(faults)


def judge(
    events: Sequence[e.Event],
    controllers: Controllers,
    killed: Mapping[str, Sequence[float]],
    *,
    heard: Sequence[e.Event] = (),
    clocks: Clocks | None = None,
) -> Verdict:
    """Compare a journal with the log of its controllers.

    :param killed: by component, when its controller was killed, seconds since the epoch
    :param heard: events that clients were told of: which work a goal was for is known from them,
        too, whatever became of the journal
    """
    verdict = Verdict()
    answers = _Answers(events)
    known = attempts(events)
    for work, goals in known.items():
        _judge_work(work, [*goals, *_unwritten(work, goals, heard)], answers, controllers, verdict)
    _judge_goals(events, controllers, verdict)
    verdict.needless_doubt += _needless(events, controllers, killed, clocks or Clocks())
    verdict.lost += _items_without_an_end(events)
    return verdict


def attempts(events: Sequence[e.Event]) -> dict[Work, list[str]]:
    """Return the goals that were to do each work."""
    goals: dict[Work, list[str]] = defaultdict(list)
    moves = 0
    for event in events:
        if isinstance(event, e.TaskStarted):
            goals[_work(event.key, moves)].append(event.goal)
        moves += isinstance(event, e.BeltIndexed)
    return goals


def _work(key: e.TaskKey, moves: int) -> Work:
    return Work(key, moves) if key == e.INDEX_KEY else Work(key)


def _unwritten(work: Work, goals: Sequence[str], heard: Sequence[e.Event]) -> list[str]:
    """Return goals for a task that the journal does not tell of."""
    if work.key == e.INDEX_KEY:
        return []  # of which move, nobody knows without the journal
    started = {x.goal for x in heard if isinstance(x, e.TaskStarted) and x.key == work.key}
    return sorted(started.difference(goals))


class _Answers:
    """What the operator decided about each work."""

    def __init__(self, events: Sequence[e.Event]) -> None:
        self._given: Counter[tuple[Work, str]] = Counter()
        held: dict[str, Work] = {}
        moves = 0
        for event in events:
            if isinstance(event, e.HoldRaised) and event.task is not None:
                key = e.TaskKey(event.job, event.section, event.item, event.task)
                held[event.hold] = _work(key, moves)
            elif isinstance(event, e.OperatorDecided) and event.hold in held:
                self._given[held[event.hold], event.answer] += 1
            moves += isinstance(event, e.BeltIndexed)

    def count(self, work: Work, answer: str) -> int:
        """Count one answer about one work."""
        return self._given[work, answer]


def _judge_work(
    work: Work,
    goals: Sequence[str],
    answers: _Answers,
    controllers: Controllers,
    verdict: Verdict,
) -> None:
    executed = sum(controllers.executions(goal) for goal in goals)
    if executed > 1 + answers.count(work, 'retry'):
        verdict.twice.append(f'{work} was executed {executed} times')
    if not executed and not answers.count(work, 'mark_done'):
        verdict.lost.append(f'{work} was never executed')


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
    events: Sequence[e.Event],
    controllers: Controllers,
    killed: Mapping[str, Sequence[float]],
    clocks: Clocks,
) -> Iterator[str]:
    component = {x.goal: x.component for x in events if isinstance(x, e.TaskStarted)}
    for event in events:
        if not isinstance(event, e.TaskFailed) or event.reason != 'in_doubt' or not event.goal:
            continue
        accepted = controllers.time_of(event.goal, 'accepted')
        ended = controllers.time_of(event.goal, 'ended')
        if accepted is None or any(t > accepted for t in killed.get(component[event.goal], ())):
            continue
        if controllers.cancelled(event.goal):
            continue
        if ended is None or clocks.real_time(event) < ended + REMEMBERED_S:
            yield f'{event.key} in doubt, though its controller knew goal {event.goal}'
