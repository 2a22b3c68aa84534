"""An operator's request to stop the cell, valid until an operator starts it (semantics 7.2)."""

from __future__ import annotations

from dataclasses import dataclass

from bt_orchestrator.model.by import named
from bt_orchestrator.model.packml import VERBS, Cause, PackmlState

STOP_AFTER = 'stop_after_'
"""Prefix of the commands that first run the line empty; `item` or `job` follows."""

AFTER, NEVER = ('item', 'job'), 'never'
"""When the line stops accepting work, and the word that withdraws the request."""

START = VERBS[Cause.START]
STAND = tuple(VERBS[cause] for cause in (Cause.STOP, Cause.ABORT, Cause.CLEAR))
"""Commands after which only an operator's `start` moves the cell."""


@dataclass(frozen=True)
class Wish:
    """An operator's request that the cell stops."""

    command: str
    """As it is recorded: stop, abort, clear, stop_after_item or stop_after_job."""
    who: str = ''
    """Empty: not known."""
    reason: str = ''
    time: float = 0.0
    """Time of the request, seconds; 0: not known."""
    known: str = ''
    """How the sender is known (`model.by`); empty: not known."""

    def __str__(self) -> str:
        return self.words()

    def words(self, clock: str = '') -> str:
        """Say who wants what, and why.

        :param clock: when it was said, by the reader's clock
        """
        at = f' at {clock}' if clock else ''
        why = f': {self.reason}' if self.reason else ''
        return f'{named(self.who, self.known)} said {self.command.replace("_", " ")}{at}{why}'


def way_to_work(mode: PackmlState) -> str:
    """Return the commands that bring a stopped or stopping cell back to work."""
    if mode in (PackmlState.RESETTING, PackmlState.IDLE):
        return 'start'
    return 'clear, reset and start' if mode in _ABORTED else 'reset and start'


_ABORTED = (PackmlState.ABORTING, PackmlState.ABORTED)
