"""The base of all events, and the key of a task."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, NamedTuple, TypeVar

from bt_orchestrator.model.script import INDEX, MANUAL


class TaskKey(NamedTuple):
    """The task and its item; unique among the tasks that can exist at one time."""

    job: str | None
    """None for the belt's own move, and for a goal of manual mode."""
    section: int | None
    """None for initialization and for the belt's own move."""
    item: str | None
    task: str

    def __str__(self) -> str:
        if self.job is None:
            return self.task
        return f'{self.task} of {self.item or self.job}'


INDEX_KEY = TaskKey(None, None, None, INDEX)
"""The belt's own move (formats: events)."""

MANUAL_KEY = TaskKey(None, None, None, MANUAL)
"""The goal of manual mode (semantics 7.11)."""


_E = TypeVar('_E', bound='Event')


@dataclass(frozen=True, kw_only=True)
class Event:
    """Base of all events. `seq` and `time` are stamped when the event is recorded."""

    event: ClassVar[str]
    """Name in the record, for instance task.started."""

    seq: int = 0
    time: float = 0.0
    """Seconds since the epoch in a real run, from 0 in a virtual one."""

    def stamp(self, seq: int, time: float) -> None:
        """Make a new event a recorded one, as `stamped` without a copy."""
        fields = vars(self)
        assert not fields['seq'], f'{fields} is recorded already'
        fields['seq'], fields['time'] = seq, time

    def stamped(self: _E, seq: int, time: float) -> _E:
        """Return a copy that is recorded."""
        copy = object.__new__(type(self))
        object.__setattr__(copy, '__dict__', {**vars(self), 'seq': seq, 'time': time})
        return copy
