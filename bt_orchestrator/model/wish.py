"""What an operator wants of the cell as a whole, until an operator starts it (semantics 7.2)."""

from __future__ import annotations

from dataclasses import dataclass

from bt_orchestrator.model.by import named
from bt_orchestrator.model.packml import VERBS, Cause, PackmlState

STOP_AFTER = 'stop_after_'
"""How the command begins that lets the line run empty first; `item` or `job` follows."""

AFTER, NEVER = ('item', 'job'), 'never'
"""After what the line may be let run empty, and the word that takes it back."""

START = VERBS[Cause.START]
STAND = tuple(VERBS[cause] for cause in (Cause.STOP, Cause.ABORT, Cause.CLEAR))
"""Commands after which only an operator's `start` moves the cell."""


@dataclass(frozen=True)
class Wish:
    """An operator wants the cell to stand."""

    command: str
    """As it is recorded: stop, abort, clear, stop_after_item or stop_after_job."""
    who: str = ''
    """Empty: not known."""
    reason: str = ''
    time: float = 0.0
    """Seconds, when it was said; 0: not known."""
    known: str = ''
    """How it is known who that is (`model.by`); empty: it is not."""

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
    """Return the commands that lead a cell that stands, or is going to, to work again."""
    if mode in (PackmlState.RESETTING, PackmlState.IDLE):
        return 'start'
    return 'clear, reset and start' if mode in _ABORTED else 'reset and start'


_ABORTED = (PackmlState.ABORTING, PackmlState.ABORTED)
