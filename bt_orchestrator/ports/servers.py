"""The action servers of a cell: goals at them, and what their types look like."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

from bt_orchestrator.model.action_type import ActionType
from bt_orchestrator.model.goal import (
    GoalEnd,
    GoalRequest,
    SafetyReading,
    SeenContest,
    SetupReading,
    StateReading,
)


class Goal(Protocol):
    """One goal at one action server.

    Its states: requested (`accepted` False, `end` None), accepted (`accepted` True, `end` None),
    ended (`end` set, for good). Only the gateway changes them.
    """

    @property
    def request(self) -> GoalRequest:
        """The question."""

    @property
    def accepted(self) -> bool:
        """True once the server accepted the goal."""

    @property
    def end(self) -> GoalEnd | None:
        """How it ended; None while it has not."""

    @property
    def feedback(self) -> Mapping[str, Any] | None:
        """Fields of the last feedback message; None if none came."""

    def cancel(self) -> None:
        """Ask the server to cancel; returns at once and may be called again.

        A goal that is not accepted yet is cancelled on acceptance (semantics 2.4); one that waits
        for its server is withdrawn and ends CANCELED. A server may refuse: then nothing changes.
        """


Told = Goal | StateReading | SetupReading | SeenContest | SafetyReading
"""News of a gateway."""


class Servers(Protocol):
    """The knowledge of the action servers without a request to them."""

    def available(self, component: str) -> bool:
        """Tell whether the component's action server was seen at the last check; for show."""

    def rivals(self, component: str) -> Sequence[str]:
        """Return the nodes that serve a component's action, if several are known now.

        Nothing is sent then: a request waits as if there were no server, and `drain` reports it
        (`SeenContest`). An answer "unknown goal" from any of them is ignored.
        """

    def server(self, component: str) -> str | None:
        """Return an id of the instance of the component's server that was seen last.

        A restarted server has another id and does not know the goals of the earlier instance. The
        id may be out of date; then only the proof that needs it fails (semantics 9.2). None: no
        server was seen, or several with one name.
        """


class ActionGateway(Servers, Protocol):
    """The only access to the robots. All calls come from the tick thread."""

    unsafe: str
    """Why the safety input is not ready at this moment (semantics 7.9); empty: it is, or the cell
    has none. `drain` tells each change, oldest first, and whether it was heard after a start."""

    def listen(self, wake: Callable[[], None]) -> None:
        """Set the function that is called whenever `drain` has an end or a state reading.

        An acceptance alone does not call it: what it changes (`task.adopted`) can wait.
        """

    def prepare(self, request: GoalRequest) -> None:
        """Do what can be done ahead for a goal that `send` may follow for; nothing is sent."""

    def send(self, request: GoalRequest) -> Goal:
        """Send one goal; returns at once, whatever the server does.

        A request without a server waits for one for the gateway's server timeout, then it ends
        UNAVAILABLE.
        """

    def adopt(self, request: GoalRequest) -> Goal:
        """Take over a goal that was sent before, perhaps by another process (semantics 9.2).

        Only its UUID is asked for; nothing is sent. Running or finished: it becomes accepted and
        ends as the server says. LOST: the server does not know it, asked again after a while
        (`GoalEnd.denied_by` tells which instance said so), or no server came within the server
        timeout.
        """

    def drain(self) -> Sequence[Told]:
        """Return what is new since the last call, oldest first.

        A goal is listed when it was accepted and when it ended; a state topic when its field's
        value changed or its publisher vanished, each setup that it tells before that value; a
        contest when it is another one.
        """


class ActionTypes(Protocol):
    """The facts of the installed interface packages about action and message types."""

    def action(self, name: str) -> ActionType:
        """Return the description of an action type such as pkg/action/Name.

        :raises UnknownActionType: it is not installed, or is no action type
        """

    def message_field(self, type_name: str, field: str) -> str:
        """Return the ROS name of the type of a message's field, for instance string.

        :raises UnknownActionType: the message type is not installed or has no such field
        """
