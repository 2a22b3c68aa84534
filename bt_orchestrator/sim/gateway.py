"""The robots in virtual time."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.goal import SERVER_TIMEOUT_S, Contest, GoalRequest
from bt_orchestrator.ports import ActionTypes, Clock, Told
from bt_orchestrator.ports.news import News
from bt_orchestrator.sim.virtual_client import VirtualClient, VirtualGoal


class VirtualGateway:
    """Every component of a cell, with nominal durations. Implements `ports.ActionGateway`.

    Nothing happens inside `send`: a goal is accepted, at the same instant, when the clock runs its
    callbacks. State topics are there from the start, before the first `drain`.
    """

    def __init__(
        self,
        cell: Cell,
        types: ActionTypes,
        clock: Clock,
        *,
        server_timeout_s: float = SERVER_TIMEOUT_S,
        duration: Callable[[GoalRequest], float] | None = None,
    ) -> None:
        """Switch the cell on.

        :param duration: seconds that a goal takes; without it the cell file's nominal ones
        :raises UnknownActionType: a component's type is not known to `types`
        """
        self._cell = cell
        self._news = News()
        self._clients = {
            component.name: VirtualClient(
                component,
                types.action(component.type),
                clock,
                self._news,
                server_timeout_s,
                duration or self._nominal_s,
            )
            for component in cell.components.values()
        }

    def listen(self, wake: Callable[[], None]) -> None:
        """Name the function to call when there is something new."""
        self._news.listen(wake)

    def prepare(self, request: GoalRequest) -> None:
        """Do nothing: in virtual time nothing takes time."""

    def send(self, request: GoalRequest) -> VirtualGoal:
        """Send one goal."""
        client = self._clients[request.component]
        goal = VirtualGoal(request, client.cancel)
        client.send(goal)
        return goal

    def adopt(self, request: GoalRequest) -> VirtualGoal:
        """Take over a goal that was sent before, by its UUID (semantics 9.2).

        The robots outlive their orchestrator: a new one takes over from a journal.
        """
        return self._clients[request.component].adopt(request)

    def drain(self) -> Sequence[Told]:
        """Return what is new."""
        return self._news.drain()

    def available(self, component: str) -> bool:
        """Tell whether the component's server is known to the graph."""
        return self._clients[component].available

    def rivals(self, component: str) -> Sequence[str]:
        """Return the servers of a component's action, if several were brought in."""
        return self._clients[component].contest.servers

    def bring_in(self, component: str, contest: Contest) -> None:
        """Set the contest of a component from now on; an empty one ends it."""
        self._clients[component].bring_in(contest)

    def server(self, component: str) -> str | None:
        """Return an id of the component's server, another one for each of its lives."""
        return self._clients[component].server

    def _nominal_s(self, request: GoalRequest) -> float:
        return self._cell.components[request.component].duration_s(request.task)
