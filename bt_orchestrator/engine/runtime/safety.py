"""The safety input: what follows when it is lost, and when it is back (semantics 7.9).

It is no safety function. One loss has one consequence, however often the input flaps meanwhile.
"""

from __future__ import annotations

from collections.abc import Iterator

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.engine.runtime.cell_commands import events_of_abort
from bt_orchestrator.engine.runtime.contests import to_be_named
from bt_orchestrator.model import events as e
from bt_orchestrator.model.commands import Command
from bt_orchestrator.model.goal import NOT_HEARD, SafetyReading
from bt_orchestrator.model.line import not_ready_words
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.state import CellState
from bt_orchestrator.model.stop_reason import SAFETY

_ABORTED = (PackmlState.ABORTING, PackmlState.ABORTED)


class SafetyGuard:
    """Tells a loss from a further cause of the same loss."""

    def __init__(self) -> None:
        self._was_told = False
        """Before that, an input that is not ready is a loss as well: that of a take-over."""

    def seen(self, state: CellState, reading: SafetyReading) -> Iterator[e.Event]:
        """Yield what follows from the present state of the input."""
        is_ready = not reading.unsafe
        is_loss = not is_ready and not (state.unsafe and self._was_told)
        self._was_told = True
        if is_loss or is_ready is bool(state.unsafe):
            yield e.SafetyChanged(ready=is_ready, reason=reading.unsafe)
        if is_loss:
            yield from _lost(state, not_ready_words(reading.unsafe))


def _lost(state: CellState, words: str) -> Iterator[e.Event]:
    """Cancel every goal, or hold the line where no goal is in flight."""
    if state.packml in _ABORTED:
        return
    if state.running:
        yield from events_of_abort(state, words)
    elif not any(hold.reason == SAFETY for hold in state.holds.values()):
        yield to_be_named(state, SAFETY, words)


def taken_over(state: CellState) -> Iterator[e.Event]:
    """Begin without news of the input, or without an input."""
    if state.cell.safety is not None:
        yield e.SafetyChanged(ready=False, reason=NOT_HEARD)
    elif state.unsafe:
        yield e.SafetyChanged(ready=True)


def refuse_unsafe(state: CellState, command: Command) -> None:
    """Refuse a request that lets something start while the input is not ready.

    :raises CommandRefused: says why it is not ready
    """
    request = getattr(command, 'request', None)
    if state.unsafe and request is not None and request.needs_safety:
        raise CommandRefused(f'{request.name} is refused: {not_ready_words(state.unsafe)}')
