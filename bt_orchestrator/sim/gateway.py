"""The robots in virtual time, and its clock."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from bt_orchestrator.base.deadlines import NS_PER_S, Deadline, Deadlines, instant_ns
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.goal import SERVER_TIMEOUT_S, Contest, GoalRequest, SafetyReading
from bt_orchestrator.model.uptime import Uptime
from bt_orchestrator.ports import ActionTypes, Clock, Told
from bt_orchestrator.ports.news import News
from bt_orchestrator.sim.virtual_client import VirtualClient, VirtualGoal


class VirtualClock:
    """Time as a number. Implements `ports.Clock`.

    Inside it counts integer nanoseconds: 1.5 + 1.0 and 2.5 are one instant, and ties are ties.
    """

    def __init__(self, start_s: float = 0.0, boot: str = 'virtual') -> None:
        """Begin.

        :param boot: of the virtual machine; times of another one cannot be compared with its own
        """
        self._boot = boot
        self._now_ns = instant_ns(start_s)
        self._now_s = self._now_ns / NS_PER_S
        self._deadlines = Deadlines()

    def now(self) -> float:
        """Return the virtual seconds; they count from 0 unless the start is another."""
        return self._now_s

    def steady(self) -> float:
        """Return the same: a virtual clock is never set."""
        return self._now_s

    def uptime(self) -> Uptime | None:
        """Return the same, of a machine that is never booted again."""
        return Uptime(self._boot, self._now_s)

    def call_at(self, time: float, callback: Callable[[], None]) -> Deadline:
        """Call back in `advance` when time has come; a time that has passed means now."""
        return self._deadlines.add(max(instant_ns(time), self._now_ns), callback)

    def next_deadline(self) -> float | None:
        """Return the seconds to which `advance` would move; None when nothing is armed."""
        time_ns = self._deadlines.next_ns()
        return None if time_ns is None else time_ns / NS_PER_S

    def advance(self) -> bool:
        """Move to the next deadline and run every callback due there, in the order armed.

        Those that a callback arms for the same instant run too, so that afterwards nothing is due.

        :return: False, without moving, when nothing is armed
        """
        time_ns = self._deadlines.next_ns()
        if time_ns is None:
            return False
        self._now_ns, self._now_s = time_ns, time_ns / NS_PER_S
        while callback := self._deadlines.pop_due(time_ns):
            callback()
        return True


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
        setups: Mapping[str, Mapping[str, str]] | None = None,
    ) -> None:
        """Switch the cell on.

        :param duration: seconds that a goal takes; without it the cell file's nominal ones
        :param setups: what components are set up for at first, where their state topics tell it
        :raises UnknownActionType: a component's type is not known to `types`
        """
        self._cell = cell
        self._news = News()
        self.unsafe = ''
        self._clients = {
            component.name: VirtualClient(
                component,
                types.action(component.type),
                clock,
                self._news,
                server_timeout_s,
                duration or self._nominal_s,
                (setups or {}).get(component.name),
            )
            for component in cell.components.values()
        }

    def listen(self, wake: Callable[[], None]) -> None:
        """Name the function to call when there is something new."""
        self._news.listen(wake)
        if self._cell.safety is not None:
            self._news.add(SafetyReading(self.unsafe))

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

    def say_of_safety(self, unsafe: str) -> None:
        """Set why the safety input is not ready; empty: it is."""
        self.unsafe = unsafe
        self._news.add(SafetyReading(unsafe))

    def available(self, component: str) -> bool:
        """Tell whether the component's server is known to the graph."""
        return self._clients[component].available

    def rivals(self, component: str) -> Sequence[str]:
        """Return the servers of a component's action, if several were brought in."""
        return self._clients[component].contest.servers

    def bring_in(self, component: str, contest: Contest) -> None:
        """Set the contest of a component from now on; an empty one ends it."""
        self._clients[component].bring_in(contest)

    def set_up(self, component: str, setup: str, value: str) -> None:
        """Let somebody change a setup by hand; its state topic tells the value, whatever it is."""
        self._clients[component].set_up(setup, value)

    def server(self, component: str) -> str | None:
        """Return an id of the component's server, another one for each of its lives."""
        return self._clients[component].server

    def _nominal_s(self, request: GoalRequest) -> float:
        return self._cell.components[request.component].duration_s(request.task)
