"""Goals that run at a server and that this process neither sent nor took over (2.5, 9.2)."""

from __future__ import annotations

import time
import uuid
from collections.abc import Iterator
from itertools import islice

from bt_orchestrator.model.contest import Contest
from bt_orchestrator.model.goal import SeenContest
from bt_orchestrator.ros.actions.endpoints import names
from bt_orchestrator.ros.actions.open_goals import OpenGoals
from bt_orchestrator.ros.actions.renewable_client import RenewableClient

LATCHED_S = 3.0
"""Seconds after a server was found in which its latched status comes, on a busy machine too."""

MOST_TOLD = 8
"""At most so many goals are named: a status may list any number, and the journal keeps the names.
"""


class Strangers:
    """Reads them from the server's status, which lists the goals of all clients."""

    def __init__(self, clients: RenewableClient, goals: OpenGoals) -> None:
        self._clients = clients
        self._goals = goals
        self._found_s: float | None = None
        self._before: dict[str, float] = {}

    def seen(self, component: str, servers: tuple[str, ...]) -> SeenContest:
        """Say who else has a part in the component now.

        :param servers: those of its action, if there are several
        """
        status = self._clients.current.status
        strange = islice(self._strange(), MOST_TOLD)
        found = {str(uuid.UUID(bytes=goal)): status.accepted_s(goal) for goal in strange}
        if self._is_early():
            self._before |= found
        before = {goal: since for goal, since in found.items() if goal in self._before}
        node = names(status.publishers_info()) if found else ''
        return SeenContest(component, Contest(servers, tuple(sorted(found))), node, before)

    def _strange(self) -> Iterator[bytes]:
        status = self._clients.current.status
        if status.is_published:
            yield from (goal for goal in status.active() if not self._goals.is_ours(goal))

    def _is_early(self) -> bool:
        """Tell whether what runs may have been begun before this process found the server."""
        now = time.monotonic()
        if self._found_s is None and self._clients.current.status.is_published:
            self._found_s = now
        return self._found_s is not None and now - self._found_s < LATCHED_S
