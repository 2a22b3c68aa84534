"""The fold that knows whether there is work: a job on the line, or one that could start."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from bt_orchestrator.model import events as e


@dataclass
class _Order:
    started: bool = False
    held: bool = False
    awaits_start: bool = False
    paused: bool = False
    unreleased: str = ''
    """Digest of its script, if that is not released."""
    lacks: set[str] = field(default_factory=set)

    @property
    def waits_for(self) -> tuple[str, ...]:
        """The obstacles to its start, in words."""
        why = {
            'held in the queue': self.held,
            'before its start': self.awaits_start,
            'script not released': self.unreleased,
            f'{", ".join(sorted(self.lacks))} out of service': self.lacks,
        }
        return tuple(words for words, is_so in why.items() if is_so and not self.started)

    @property
    def is_at_hand(self) -> bool:
        waits = self.held or self.awaits_start or self.unreleased or self.lacks
        return self.started or not waits


class OrdersAtHand:
    """Takes in one event after another; knows the jobs that have not ended, and nothing more."""

    def __init__(self) -> None:
        self._orders: dict[str, _Order] = {}

    @property
    def any(self) -> bool:
        """Tell whether there is work (as `CellState.has_work`)."""
        return any(one.is_at_hand for one in self._orders.values())

    @property
    def waits_for(self) -> str:
        """The obstacles to the start of all orders; empty: there is no order."""
        return '; '.join(sorted({why for one in self._orders.values() for why in one.waits_for}))

    @property
    def all_paused(self) -> bool:
        """Tell whether there are jobs on the line, and an operator has paused all of them."""
        line = [one.paused for one in self._orders.values() if one.started]
        return bool(line) and all(line)

    def follow(self, event: e.Event) -> None:
        """Take in the next event."""
        if isinstance(event, e.OrderEvent):
            self._queued(event)
        elif isinstance(event, e.ComponentOutOfService):
            for job in event.jobs:
                self._orders.setdefault(job, _Order()).lacks.add(event.component)
        elif isinstance(event, e.ComponentInService):
            for one in self._orders.values():
                one.lacks.discard(event.component)
        elif isinstance(event, e.ScriptReleased):
            for one in self._orders.values():
                if one.unreleased == event.digest:
                    one.unreleased = ''
        elif isinstance(event, _LEAVES):
            self._orders.pop(event.job, None)
        elif isinstance(event, _CHANGES):
            order = self._orders.setdefault(event.job, _Order())
            vars(order).update(_VALUES[type(event)])

    def plain(self) -> dict[str, Any]:
        """Return what it knows, as JSON carries it."""
        return {
            job: {**vars(one), 'lacks': sorted(one.lacks)} for job, one in self._orders.items()
        }

    def go_on_from(self, plain: Mapping[str, Any]) -> None:
        """Know what another one knew."""
        self._orders = {
            job: _Order(**{**one, 'lacks': set(one['lacks'])}) for job, one in plain.items()
        }

    def _queued(self, event: e.OrderEvent) -> None:
        order = self._orders.setdefault(event.job, _Order())
        if isinstance(event, e.JobQueued):
            order.held = event.held
        order.awaits_start, order.lacks = event.awaits_start, set(event.unavailable)
        order.unreleased = event.digest if event.awaits_release else ''


_LEAVES = (e.JobRemoved, e.JobCompleted, e.JobAborted)

_CHANGES = (
    e.JobStarted,
    e.JobHeld,
    e.JobReleased,
    e.JobMayStart,
    e.JobPaused,
    e.JobResumed,
    e.JobStopping,
    e.JobAborting,
)

_VALUES: Mapping[type[e.Event], Mapping[str, object]] = {
    e.JobStarted: {'started': True},
    e.JobHeld: {'held': True},
    e.JobReleased: {'held': False},
    e.JobMayStart: {'awaits_start': False},
    e.JobPaused: {'paused': True},
    e.JobResumed: {'paused': False},
    e.JobStopping: {'paused': False},
    # It has to end, also if it never began.
    e.JobAborting: {'started': True, 'held': False, 'awaits_start': False, 'paused': False},
}

FOLLOWED = (
    *(kind.event for kind in (e.JobQueued, e.JobUpdated)),
    *(kind.event for kind in _CHANGES),
    *(kind.event for kind in _LEAVES),
    e.ComponentOutOfService.event,
    e.ComponentInService.event,
    e.ScriptReleased.event,
)
