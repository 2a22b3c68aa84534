"""How often tasks run and fail: as their file says, or as a journal tells (semantics 8.4)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from bt_orchestrator.base.errors import counted
from bt_orchestrator.model import events as e
from bt_orchestrator.model.goal import Reason
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.model.script import Likely, Script, Task
from bt_orchestrator.view.report.reading import Reading

LEAST = 20
"""Times that a journal has to have seen something before its share counts."""

RUNS, FAILS = 'runs', 'fails'

_NO_RATE = Likely()
_REPORTED = (Reason.ABORTED, Reason.TASK_RESULT_FALSE, Reason.GOAL_REJECTED, Reason.TIMEOUT)
_FOLLOWED = (
    e.JobQueued,
    e.JobUpdated,
    e.TaskStarted,
    e.TaskSkipped,
    e.TaskSucceeded,
    e.TaskFailed,
)


@dataclass(frozen=True)
class Rate:
    """How often one task runs, or fails."""

    task: str
    what: str
    """`RUNS`, for a share of the items, or `FAILS`, for a share of the attempts."""
    share: float
    of: int | None = None
    """Items or attempts that the journal has seen; None: its file says it."""

    def __str__(self) -> str:
        percent = f'{100 * self.share:.3g} %'
        if self.what == RUNS:
            seen = 'items' if self.of is None else counted(self.of, 'item')
            return f'{self.task} runs for {percent} of {seen}'
        return f'{self.task} fails {percent} of {_attempts(self.of)}'


def _attempts(count: int | None) -> str:
    return 'its attempts' if count is None else counted(count, 'attempt')


class _Seen(NamedTuple):
    script: str
    """Name of the script."""
    task: str
    what: str
    """`task.started`, `task.succeeded`, or the reason of a skip or a failure."""


class RatesSeen:
    """Counts what became of tasks, in the events of a journal."""

    def __init__(self) -> None:
        self._script_of: dict[str, str] = {}
        self._counts: Counter[_Seen] = Counter()

    def follow(self, event: e.Event) -> None:
        """Take in the next event."""
        if isinstance(event, (e.JobQueued, e.JobUpdated)):
            self._script_of[event.job] = event.script
        elif isinstance(event, e.TaskStarted):
            if event.attempt == 1 and not event.round:
                self._count(event, event.event)
        elif isinstance(event, e.TaskSucceeded):
            self._count(event, event.event)
        elif isinstance(event, (e.TaskSkipped, e.TaskFailed)):
            self._count(event, event.reason)

    def runs(self, script: Script, task: Task) -> Rate | None:
        """Return how often the condition of a task let it run; None: seen too few times."""
        ran, skipped = self._of(script, task, e.TaskStarted.event, str(task.condition))
        return _rate(task, RUNS, ran, ran + skipped)

    def fails(self, script: Script, task: Task) -> Rate | None:
        """Return how often a task failed, or its verdict refused; None: seen too few times."""
        reasons = _REPORTED if task.fails_unless is None else (Reason.RESULT_REFUSED,)
        done, *failed = self._of(
            script, task, e.TaskSucceeded.event, *(reason.value for reason in reasons)
        )
        return _rate(task, FAILS, sum(failed), done + sum(failed))

    def _count(self, event: e.TaskEvent, what: str) -> None:
        if event.item is not None and event.job in self._script_of:
            self._counts[_Seen(self._script_of[event.job], event.task, what)] += 1

    def _of(self, script: Script, task: Task, *what: str) -> list[int]:
        return [self._counts[_Seen(script.name, task.id, kind)] for kind in what]


def rates_seen(reading: Reading) -> RatesSeen:
    """Count what a journal tells of tasks."""
    seen = RatesSeen()
    for event in reading.events(Wanted(events=tuple(kind.event for kind in _FOLLOWED))):
        seen.follow(event)
    return seen


def rates_of(script: Script, seen: RatesSeen) -> Iterator[Rate]:
    """Yield all rates that are known: those that were seen, else those of the file."""
    for section in script.sections.values():
        for task in section.tasks:
            likely = script.likely.get(task.id, _NO_RATE)
            if task.condition is not None:
                yield from _known(seen.runs(script, task), task, RUNS, likely.runs)
            if task.fails_by_itself:
                yield from _known(seen.fails(script, task), task, FAILS, likely.fails)


def _known(seen: Rate | None, task: Task, what: str, likely: float | None) -> Iterator[Rate]:
    if seen is not None:
        yield seen
    elif likely is not None:
        yield Rate(task.id, what, likely)


def _rate(task: Task, what: str, count: int, of: int) -> Rate | None:
    return Rate(task.id, what, count / of, of) if of >= LEAST else None
