"""When jobs are expected to end, kept up to date while the cell works."""

from __future__ import annotations

import time
from collections.abc import Mapping

from rclpy.node import Node

from bt_orchestrator.engine.runtime.observed_durations import ObservedDurations, as_observed
from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.keeping.snapshot import nearest, state_to_text
from bt_orchestrator.model.limits import QUEUE_SHOWN
from bt_orchestrator.model.state import CellState
from bt_orchestrator.ports import Foresight
from bt_orchestrator.ros.executor.heart import Pulse
from bt_orchestrator.view.report.pace import Paces, expected_ends_s

RENEW_S = 5.0
"""Shortest time between two questions about one queue."""

SELDOM_S = 20.0
"""Longest time between them. The time doubles while each answer is like the one before."""

ALIKE_S, ALIKE = 1.0, 0.01
"""Two forecasts of an end are alike when they differ by less than this, or than this share of the
time that is left."""

RESTS = 20
"""So many times as long as a forecast has taken is the shortest time to the next: it is the engine
in virtual time, and a long queue would keep a processor busy."""


class ExpectedEnds:
    """Asks for a forecast when the queue or the holds changed, and now and then during work."""

    def __init__(
        self,
        node: Node,
        orchestrator: Orchestrator,
        durations: ObservedDurations,
        foresight: Foresight | None,
        pulse: Pulse,
    ) -> None:
        """Look ahead, once a second at most.

        :param foresight: makes forecasts; None: the pace has to do
        """
        self._node = node
        self._orchestrator = orchestrator
        self._durations = durations
        self._foresight = foresight
        self._asked_s = 0.0
        self._asked_seq = 0
        self._asked_about: object = None
        self._asked_ends_s: Mapping[str, float] = {}
        self._renew_s = RENEW_S
        self._paces = Paces()
        self._cell: Cell | None = None
        """With the durations seen; None: to be made anew when it is needed."""
        pulse.add(self._look)

    def within_s(self, now_s: float) -> Mapping[str, float]:
        """Return in how many seconds each live job ends; ends that cannot be known are left out.

        By the last forecast, which knows nothing while somebody has to answer or start first; what
        it does not know, by the pace. Both take the durations that were seen.
        """
        state = self._orchestrator.state
        foresight = None if _waits(state) else self._foresight
        ends_s = foresight.ends_s if foresight is not None else {}
        known = {job: max(0.0, end_s - now_s) for job, end_s in ends_s.items()}
        if all(job.job.id in known for job in state.jobs.first(QUEUE_SHOWN)):
            return known
        if self._cell is None:
            self._cell = as_observed(state.cell, self._durations.seconds())
        return {**expected_ends_s(state, self._cell, self._paces), **known}

    def close(self) -> None:
        """Stop asking."""
        if self._foresight is not None:
            self._foresight.close()

    def _look(self) -> None:
        state = self._orchestrator.state
        self._cell = None
        if self._foresight is None:
            return
        if not state.jobs or _waits(state):
            self._asked_about = None
            return
        steady_s = time.monotonic()
        jobs = (job.job.id for job in state.jobs.first(QUEUE_SHOWN))
        about = (*jobs, self._durations.kinds)  # a task seen first changes what is known
        rest_s = max(self._renew_s, RESTS * self._foresight.took_s)
        renews = steady_s - self._asked_s >= rest_s and state.seq != self._asked_seq
        if about != self._asked_about or renews:
            now_s = self._node.get_clock().now().nanoseconds / 1e9
            ends_s = self._foresight.ends_s
            goes_on = about == self._asked_about and _alike(self._asked_ends_s, ends_s, now_s)
            self._renew_s = min(2 * self._renew_s, SELDOM_S) if goes_on else RENEW_S
            self._asked_s, self._asked_seq, self._asked_about = steady_s, state.seq, about
            self._asked_ends_s = ends_s
            text = state_to_text(nearest(state))
            self._foresight.ask(text, self._durations.seconds(), now_s)


def _alike(before_s: Mapping[str, float], after_s: Mapping[str, float], now_s: float) -> bool:
    """Tell whether two forecasts are of the same jobs and say much the same."""
    return before_s.keys() == after_s.keys() and all(
        abs(end_s - before_s[job]) <= max(ALIKE_S, ALIKE * (end_s - now_s))
        for job, end_s in after_s.items()
    )


def _waits(state: CellState) -> bool:
    """Tell whether a person has to do something first: the time for that is not known."""
    return bool(state.holds) or state.stopped_by is not None
