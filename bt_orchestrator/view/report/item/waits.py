"""The waits of an item: the engine's teller, asked at each moment of a journal."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import replace

from bt_orchestrator.model import events as e
from bt_orchestrator.model.fold import apply
from bt_orchestrator.model.state import CellState, Phase
from bt_orchestrator.model.waits.waiting import Waiting, at_bottom, of_item
from bt_orchestrator.view.report.item.history import Waited
from bt_orchestrator.view.report.past_state import MISFITS

LEAST_S = 0.02
"""A shorter wait is the time that the program and the disk need."""


class ItemWaits:
    """Takes in all events from a state before an item on, in order.

    The events of one moment belong together: what is told between them is not what was so. Of
    servers the journal has what the engine recorded (contests), of delays when each one ends.
    """

    def __init__(self, item: str, state: CellState | None) -> None:
        """Begin.

        :param state: changed with the events; None: it is not known, and nothing is told
        """
        self.unknown_since = -math.inf if state is None else math.inf
        """From when on the state is not known."""
        self._item = item
        self._state = state
        self._pending: dict[e.TaskKey | None, list[Waited]] = defaultdict(list)
        """The waits of tasks that have not begun; None: no task."""
        self._time = 0.0
        self._started = 0.0
        """When the last orchestrator was started: delays from before a boot begin anew then."""

    def follow(self, event: e.Event) -> None:
        """Take in the next event."""
        state = self._state
        if state is None:
            return
        self._ask(state, event.time)
        if isinstance(event, e.OrchestratorStarted):
            self._started = event.time
        try:
            apply(state, event)
        except MISFITS:  # events are missing, or of another program
            self._state, self.unknown_since = None, event.time

    def before(self, key: e.TaskKey | None) -> list[Waited]:
        """Return what a task waited for before it began, or was passed, each part once."""
        waited = self._pending.pop(key, [])
        return [wait for wait in waited if wait.seconds >= LEAST_S]

    def rest(self) -> list[Waited]:
        """Return what was waited for by tasks that never began."""
        waits = (wait for key in tuple(self._pending) for wait in self.before(key))
        return sorted(dict.fromkeys(waits), key=lambda wait: wait.start)

    def _ask(self, state: CellState, until: float) -> None:
        """Ask what the item has waited for until now; the end of a delay is a moment too."""
        item = state.items.get(self._item)
        while self._time < until:
            waitings = () if item is None else tuple(of_item(state, item, self))
            waits = tuple(
                waiting._replace(wait=at_bottom(state, waiting.wait, self)) for waiting in waitings
            )
            delayed = (key for key, t in state.tasks.items() if t.phase is Phase.RETRYING)
            end = min([until, *filter(self._time.__lt__, map(self._over, delayed))])
            self._note(self._time, end, waits)
            self._time = end

    def _note(self, start: float, end: float, waits: Iterable[Waiting]) -> None:
        for wait, tasks, _ in waits:
            for key in tasks or (None,):
                pending, kind = self._pending[key], wait.kind.value
                last = pending[-1] if pending else None
                if last and (last.end, last.kind, last.words) == (start, kind, wait.reason):
                    pending[-1] = replace(last, end=end)
                else:
                    pending.append(Waited(start, end, kind, wait.reason))

    # --- what the engine has besides the state: implements `model.waits.starting.Seen` ----------

    def rivals(self, component: str) -> Sequence[str]:  # noqa: ARG002 - the engine's
        """Return nothing: contests are in the state."""
        return ()

    def is_delayed(self, key: e.TaskKey) -> bool:
        """Tell whether the next attempt of a task waits for its delay."""
        return self._over(key) > self._time

    def awaits_setup(self, key: e.TaskKey) -> bool:  # noqa: ARG002 - the engine's
        """Return True: the end of this wait is an event."""
        return True

    def _over(self, key: e.TaskKey) -> float:
        """Return when the delay of a task is over."""
        assert self._state is not None
        task = self._state.tasks[key]
        if task.delayed_up is not None and task.delayed_up.boot != self._state.boot:
            return self._started + task.delay_s
        return task.not_before
