"""The robots of an orchestrator that is killed between a commit and the sending."""

from __future__ import annotations

from bt_orchestrator.model.goal import GoalRequest
from bt_orchestrator.sim.gateway import VirtualGateway
from bt_orchestrator.sim.virtual_client import VirtualGoal


class DyingGateway(VirtualGateway):
    """Its goals of one task do not reach their server."""

    unsent: str | None = None
    """Name of that task."""

    def send(self, request: GoalRequest) -> VirtualGoal:
        if request.task == self.unsent:
            return VirtualGoal(request, lambda goal: None)
        return super().send(request)
