"""`~/get_state`: the current state, for predictions by a client."""

from __future__ import annotations

import json
from typing import Any

from bt_orchestrator_interfaces.srv import GetState
from rclpy.node import Node

from bt_orchestrator.engine.runtime.observed_durations import ObservedDurations
from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.model.codec import to_plain
from bt_orchestrator.model.keeping.snapshot import nearest, state_to_text
from bt_orchestrator.ros.services.serving import serve


class StateService:
    """Answers with what is durable; a state that waits for the disk is refused."""

    def __init__(
        self, node: Node, orchestrator: Orchestrator, durations: ObservedDurations
    ) -> None:
        self._node = node
        self._orchestrator = orchestrator
        self._durations = durations
        serve(node, GetState, 'get_state', self._answer)

    async def _answer(self, _: Any, response: Any) -> None:
        if self._orchestrator.awaits_disk:
            response.message = f'not at this moment: {self._orchestrator.disk_wait}'
            return
        state = self._orchestrator.state
        response.cell = json.dumps(to_plain(state.cell))
        response.state = state_to_text(nearest(state, with_ids=True))
        response.observed = json.dumps(self._durations.seconds())
        response.now = self._node.get_clock().now().nanoseconds / 1e9
        response.history, response.seq = state.history, state.seq
        response.accepted = True
