"""The fold that pairs the start of an attempt of a task with its end."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from bt_orchestrator.model import events as e


class TaskSpan(NamedTuple):
    """One attempt, from its goal to its end."""

    started: e.TaskStarted
    ended: e.TaskSucceeded | e.TaskFailed

    @property
    def seconds(self) -> float:
        """How long it took."""
        return self.ended.time - self.started.time


class TaskSpans:
    """Takes in one event after another."""

    def __init__(self) -> None:
        self._open: dict[e.TaskKey, e.TaskStarted] = {}

    def follow(self, event: e.Event) -> TaskSpan | None:
        """Take in the next event; returns the attempt that it ends.

        A task may fail without an attempt, for instance because a result is missing. If the clock
        is set, open starts get the time that the new clock would have shown.
        """
        if isinstance(event, e.TaskStarted):
            self._open[event.key] = event
        elif isinstance(event, (e.TaskSucceeded, e.TaskFailed)):
            started = self._open.pop(event.key, None)
            return None if started is None else TaskSpan(started, event)
        elif isinstance(event, e.ClockStepped) and event.seconds:
            for key, one in self._open.items():
                self._open[key] = one.stamped(one.seq, one.time + event.seconds)
        return None

    def open(self) -> Iterator[e.TaskStarted]:
        """Yield the attempts that have not ended, oldest first."""
        yield from self._open.values()

    def start_of(self, event: e.TaskEvent) -> e.TaskStarted | None:
        """Return the start of the attempt that is in flight for a task."""
        return self._open.get(event.key)

    def forget(self) -> None:
        """Forget all starts: later ends pair with no start of before."""
        self._open.clear()
