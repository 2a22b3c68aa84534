"""Data of goals: requests to an action server, and their ends."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from bt_orchestrator.model.contest import Contest
from bt_orchestrator.model.frozen import made_at_once
from bt_orchestrator.model.words import sentence

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
