"""What is seen of a simulated controller with a fault, of every kind, through any gateway."""

from __future__ import annotations

from itertools import groupby
from typing import NamedTuple

from contract.gateway_bench import Bench, Log

from bt_orchestrator.model.fault import FaultKind
from bt_orchestrator.model.goal import GoalStatus


class Story(NamedTuple):
    """What becomes of the first goal of a component with a fault, and of the next one."""

    fault: str
    end: GoalStatus | None
    """None: it goes on."""
    done: bool = False
    """Its `task_result`."""
    accepted: bool = True
    hangs: bool = False
    """It is cancelled when it should have ended long ago."""
    then: GoalStatus | None = GoalStatus.SUCCEEDED
    """How the next goal ends; None: nothing else is to be seen."""
    said: tuple[str, ...] = ('READY',)
    """By the state topic, all in all."""


STORIES = {
    FaultKind.FALSE: Story('=false', GoalStatus.SUCCEEDED),
    FaultKind.REJECT: Story('=reject', GoalStatus.REJECTED, accepted=False),
    FaultKind.ABORT: Story('=abort', GoalStatus.ABORTED),
    FaultKind.CANCEL: Story('=cancel', GoalStatus.CANCELED),
    FaultKind.HANG: Story('=hang', GoalStatus.CANCELED, hangs=True),
    FaultKind.IGNORE_CANCEL: Story('=ignore_cancel', None, hangs=True, then=GoalStatus.REJECTED),
    FaultKind.LATE: Story('=late:0.6', GoalStatus.SUCCEEDED, done=True),
    FaultKind.READS: Story('=reads:4.2', GoalStatus.SUCCEEDED, done=True),
    FaultKind.MUTE: Story('=mute', GoalStatus.LOST, accepted=False),
    FaultKind.DIE: Story('=die:0.1', GoalStatus.LOST),
    FaultKind.ABSENT: Story('=absent', GoalStatus.UNAVAILABLE, accepted=False, then=None, said=()),
    FaultKind.NOT_READY: Story(
        '=not_ready', GoalStatus.SUCCEEDED, done=True, said=('READY', 'NOT_READY')
    ),
    FaultKind.SILENT: Story('=silent', GoalStatus.SUCCEEDED, done=True, said=()),
}


class FaultyCell(NamedTuple):
    """A component of each kind of fault, and all that was told since the start."""

    bench: Bench
    log: Log

    def said(self, kind: FaultKind) -> list[object]:
        """Return what a state topic has said, without gaps and repetitions."""
        values = [value for value in self.log.readings(kind.value) if value is not None]
        return [value for value, _ in groupby(values)]
