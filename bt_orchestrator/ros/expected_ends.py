"""When jobs are expected to end, kept up to date while the cell works."""

from __future__ import annotations

import json
from collections.abc import Mapping

from rclpy.node import Node

from bt_orchestrator.model.snapshot import state_to_plain
from bt_orchestrator.model.state import CellState
from bt_orchestrator.ports import Foresight
from bt_orchestrator.ros.pulse import Pulse
from bt_orchestrator.runtime.observed_durations import ObservedDurations
from bt_orchestrator.runtime.orchestrator import Orchestrator

RENEW_S = 5.0
"""Shortest time between two questions about one queue that goes on as expected."""


class ExpectedEnds:
    """Asks for a forecast when the queue or the holds changed, and every few seconds of work."""

    def __init__(
        self,
        node: Node,
        orchestrator: Orchestrator,
        durations: ObservedDurations,
        foresight: Foresight,
        pulse: Pulse,
    ) -> None:
        self._node = node
        self._orchestrator = orchestrator
        self._durations = durations
        self._foresight = foresight
        self._asked_s = 0.0
        self._asked_seq = 0
        self._asked_about: object = None
        pulse.add(self._look)

    @property
    def ends_s(self) -> Mapping[str, float]:
        """Seconds since the epoch, by job; nothing while somebody has to answer or start first."""
        return {} if _waits(self._orchestrator.state) else self._foresight.ends_s

    def close(self) -> None:
        """Ask no more."""
        self._foresight.close()

    def _look(self) -> None:
        state = self._orchestrator.state
        if not state.jobs or _waits(state):
            self._asked_about = None
            return
        now_s = self._node.get_clock().now().nanoseconds / 1e9
        about = tuple(state.jobs)
        renews = now_s - self._asked_s >= RENEW_S and state.seq != self._asked_seq
        if about != self._asked_about or renews:
            self._asked_s, self._asked_seq, self._asked_about = now_s, state.seq, about
            text = json.dumps(state_to_plain(state))
            self._foresight.ask(text, self._durations.seconds(), now_s)


def _waits(state: CellState) -> bool:
    """Tell whether a person has to do something first: nobody knows how long that takes."""
    return bool(state.holds) or state.stopped_by is not None
