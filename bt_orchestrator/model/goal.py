"""Data of goals: requests to an action server, their ends, and goals and servers of others."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from bt_orchestrator.model.action_type import MessageType
from bt_orchestrator.model.frozen import made_at_once
from bt_orchestrator.model.limits import SAID, cut
from bt_orchestrator.model.words import Words, sentence

SERVER_TIMEOUT_S = 5.0
"""Seconds that a request waits for a server that is not there."""

RESULT_CHECK_S = 2.0
"""Seconds after which the result of a goal in flight is asked for again (semantics 9.3)."""

SILENCE_S = 3 * RESULT_CHECK_S
"""Seconds without a word from a server that has to answer, after which something is wrong.

Three questions; discovery, after which answers come, takes up to 3 s (semantics 9.3).
"""

SERVER_LEASE_S = 20.0
"""Seconds after which the ROS graph has forgotten a killed server (semantics 9.3)."""

RESULT_TIMEOUT_S = 10.0
"""Seconds for which a server remembers a goal that ended, unless the cell file says otherwise.

rclpy's default (semantics 9.2).
"""

REQUEST_CHECKS = 2
"""Checks in a row at which the server must not know an unanswered request for it to be LOST.

Two, because the first may arrive before the server has decided on the request.
"""


class Reason(Enum):
    """Why an attempt failed (semantics 2.3)."""

    SERVER_UNAVAILABLE = 'server_unavailable'
    GOAL_REJECTED = 'goal_rejected'
    ABORTED = 'aborted'
    CANCELED = 'canceled'
    TIMEOUT = 'timeout'
    TASK_RESULT_FALSE = 'task_result_false'
    RESULT_REFUSED = 'result_refused'
    DUPLICATE_SERIAL = 'duplicate_serial'
    MISSING_RESULT = 'missing_result'
    SETUP_MISSING = 'setup_missing'
    SERVER_LOST = 'server_lost'
    IN_DOUBT = 'in_doubt'


WITHDRAWN = sentence('withdrawn')
"""Message of a goal that was cancelled while it waited for its server."""


class GoalStatus(Enum):
    """How a goal ended, as far as the gateway can tell."""

    SUCCEEDED = 'succeeded'
    ABORTED = 'aborted'
    CANCELED = 'canceled'
    REJECTED = 'rejected'
    """The server rejected the request."""
    UNAVAILABLE = 'unavailable'
    """No server came in time; the request was never sent."""
    LOST = 'lost'
    """The server that had the goal is gone or does not know it any more (semantics 9.3)."""
    SILENT = 'silent'
    """The server is there but does not answer: whether the goal still runs is unknown (9.3)."""


@made_at_once
@dataclass(frozen=True)
class GoalRequest:
    """One attempt at a task, ready to be sent."""

    id: str
    """Goal UUID, new for every attempt (semantics 9.2)."""
    component: str
    task: str
    """Task constant, or a label where the action type has no task field."""
    args: Mapping[str, Any] = field(default_factory=dict)
    """Goal fields with plain values, references resolved."""


@made_at_once
@dataclass(frozen=True)
class GoalEnd:
    """The end of a goal."""

    status: GoalStatus
    result: Mapping[str, Any] = field(default_factory=dict)
    """Result fields with plain values; empty unless the server sent a result."""
    message: str = ''
    """Message of the server or the gateway, for a person."""
    denied_by: str | None = None
    """Instance of the server that does not know a goal of an earlier process; None: not known."""
    topic_says: str = ''
    """Without a result: the end of the goal by the status topic, which decides nothing (decision
    0018): succeeded, canceled or aborted; empty: it does not say."""
    never_begun: bool = False
    """It was cancelled, and no server ever had it."""


@dataclass(frozen=True)
class SeenContest:
    """A changed contest of a component (semantics 2.5)."""

    component: str
    contest: Contest
    node: str = ''
    """Node of the server; empty: none, or not known."""
    before: Mapping[str, float] = field(default_factory=dict)
    """Goals that already ran when the server was first found, with the times of their acceptance,
    in seconds on the server's clock (semantics 9.2)."""


@dataclass(frozen=True)
class StateReading:
    """A change seen on a component's state topic (semantics 2.5)."""

    component: str
    value: Any
    """The value of the field; None: nothing is published there (any more)."""


@dataclass(frozen=True)
class SetupReading:
    """A change seen in what a component's state topic tells of a setup (semantics 5.3)."""

    component: str
    setup: str
    value: str | None
    """Its value, or another text; None: nothing is published there (any more)."""


NOT_HEARD = sentence('unsafe_unheard')
"""Why a safety input is not ready at first."""


@dataclass(frozen=True)
class SafetyReading:
    """The state of the safety input (semantics 7.9)."""

    unsafe: str
    """Why it is not ready; empty: it is."""


# The words of a controller about a failed attempt: the texts of its Result.

MESSAGE_FIELD = 'message'
"""Field of a Result that is meant for a person, by custom."""


def controller_words(result: Mapping[str, Any]) -> str:
    """Return `message` of a result; if that is empty, every text in it with its name."""
    message = result.get(MESSAGE_FIELD)
    if isinstance(message, str) and message.strip():
        return cut(message.strip(), SAID)
    return cut('; '.join(f'{name}: {text}' for name, text in _texts(result, '')), SAID)


def words_field(result: MessageType) -> str:
    """Return the field of a Result in which a simulated controller says something; empty: none."""
    texts = [
        name for name, field in result.fields.items() if field.kind == 'str' and not field.is_array
    ]
    return MESSAGE_FIELD if MESSAGE_FIELD in texts else next(iter(texts), '')


def _texts(value: object, place: str) -> Iterator[tuple[str, str]]:
    """Yield every text that is not blank, with its place."""
    if isinstance(value, str):
        if value.strip():
            yield place, value.strip()
    elif isinstance(value, Mapping):
        for name, member in value.items():
            yield from _texts(member, f'{place}.{name}' if place else str(name))
    elif isinstance(value, (list, tuple)):
        for number, member in enumerate(value):
            if not isinstance(member, (bool, int, float)):
                yield from _texts(member, f'{place}[{number}]')


# Contests: a second server of a component, or goals that are not the line's (2.5).


@dataclass(frozen=True)
class Contest:
    """Other servers or clients of a component; empty: only the line uses it."""

    servers: tuple[str, ...] = ()
    """Nodes of all servers of its action, if there are several: each would execute a goal."""
    goals: tuple[str, ...] = ()
    """UUIDs of goals there that belong to no task of the line."""

    def __bool__(self) -> bool:
        """Tell whether there is a contest."""
        return bool(self.servers or self.goals)

    def wait(self, component: str, action: str) -> str:
        """Say what a task waits for."""
        if self.servers:
            return f'waiting for {component} to have one server; there are {self.words(action)}'
        return f'waiting for {component}; {self.words(action)}'

    def facts(self, action: str) -> Words:
        """Return what `words` says as facts, of a contest that there is."""
        if self.servers:
            count, servers = str(len(self.servers)), ', '.join(self.servers)
            return Words('several_servers', {'action': action, 'count': count, 'servers': servers})
        kind = 'foreign_goals' if len(self.goals) > 1 else 'foreign_goal'
        return Words(kind, {'goals': ', '.join(self.goals)})

    def words(self, action: str) -> str:
        """Describe the contest; empty: there is none."""
        return self.facts(action).text() if self else ''


NO_CONTEST = Contest()
