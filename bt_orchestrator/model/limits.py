"""Limits of external input: no client can fill the journal, a log or the memory.

A request that exceeds a limit is refused with a message; data of a controller is cut, with a mark
that says how much is missing, because its goal has ended anyway.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Hashable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from typing import Any, TypeVar

_T = TypeVar('_T')

REQUEST_BYTES = 1_000_000
"""Longest request, all its texts together."""

ORDERS = 250
"""Maximum number of work orders in one request. They are queued in one settle, all or none, which
blocks other requests for 0.2 ms per order.

A bound in QueueAdd.srv would save the node nothing: the C type support of Fast DDS, which rclpy
uses, checks bounds only in what it sends. A request with 20,000 orders took 0.17 s to take with
and without `WorkOrder[<=250]` (Jazzy; Kilted has the same code), and its client would not be told
the limit."""

INITIALIZATION = 500
"""Maximum number of initialization tasks of a script: they wait in parallel, and each is checked
repeatedly."""

OPERATIONS = 1_000
"""Maximum number of operations of a recipe: what comes before each is known of all of them."""

GENERATING_S = 120.0
"""Longest time to generate the scripts of one request; 30 operations take about a second."""

DETAILS_BYTES = 8_000
"""Longest details of a work order, as JSON."""

DETAILS_DEPTH = 16
"""Most lists and mappings within each other in them."""

FINDINGS = 100
"""Most mistakes that are listed in the answer to a request."""

WHO = 200
"""Longest name of a sender, in characters."""

ORIGIN = 200
"""Longest name of the place that a command comes from, in characters."""

REASON = 2_000
"""Longest reason for a command, in characters."""

NAME = 200
"""Longest name in a request: of a hold, a job, an item, a script, a word of command."""

MESSAGE = 2_000
"""Longest words about a failure that are kept, in characters."""

SAID = 500
"""Longest text of a controller's own result about a failure that is kept, in characters."""

LAST_FEEDBACK_BYTES = 2_000
"""Longest last feedback of a failed attempt that is kept."""

STATE_VALUE_BYTES = 64_000
"""Longest value of a state topic that is kept."""

STATE_VALUE_SHORT = 1_000
"""The same when a topic exceeds its rate limit."""

FEEDBACK_BYTES = 16_000
"""Longest feedback that a status shows."""

RESULTS_TEXT = 64_000
"""Longest text with results that an operator gives, in characters."""

RESULT_BYTES = 4_000_000
"""Most that is kept of one result; the longest fields beyond that are left out."""

SERIAL = 200
"""Longest serial of an item, and name of a lot, in characters."""

PLACE = 100
"""Longest name of a computer or a cell that another node tells of itself, in characters."""

PAUSES = 32
"""Maximum number of pauses at a time; one already stops all starts."""

TWINS = 8
"""Maximum number of holds at a time because of nodes with the same name."""

EVENTS_BYTES = 1_000_000
"""Longest answer to a client that asks for events, as JSON; one event is always told."""

STREAMS = 8
"""Most streams of the tree, and of the blackboard, that tree watchers have at a time."""

NAMES_LISTED = 20
"""Most names that a message lists."""


@dataclass(frozen=True)
class Share:
    """A rate limit: an amount at once, and an amount per second."""

    at_once: float
    per_s: float


STATES_OF_ONE = Share(128e3, 2e3)
"""Bytes that the values of one state topic write to the journal."""

LOG_LINES = Share(50, 0.1)
"""Lines that one part of the node logs about what others send."""

UNHEARD_S = Share(2.0, 0.1)
"""Seconds of the tick thread that one service may spend on answers to clients that are gone."""

UNHEARD_TOGETHER_S = Share(4.0, 0.2)
"""The same of all services together that have made such answers lately."""

REFUSED_GOALS = Share(1_000, 1.0)
"""Goals of `run_job` that are refused with words; each result is kept for a while."""

COMMANDS_OF_ONE = Share(16e6, 2e3)
"""Bytes that the commands of one sender write; a work order writes about 600."""

COMMANDS = Share(32e6, 2e3)
"""Bytes that the commands of all senders write together."""

REFUSALS_OF_ONE = Share(16e3, 100.0)
"""Bytes of the single records of refused commands, of one sender; others are counted."""

REFUSALS = Share(64e3, 300.0)
"""Bytes of the single records of refused commands, of all senders together."""


QUEUE_SHOWN = 100
"""Number of jobs of the queue in a status and in forecasts."""

ENDED_KEPT = 100
"""Number of ended jobs that a cell lists unless somebody clears them, the last ones; the journal
has them all."""

RELEASED_KEPT = 64
"""Number of released scripts of orders by recipe that a cell keeps, those that were used last."""

ENDED_SHOWN = 10
"""Number of them in a status, which is sent often; the others are asked for."""

EVENTS_PAGE = 200
"""Most events in one answer: reading them blocks the tick thread for a few milliseconds."""

QUEUE_PAGE = 500
"""Most jobs of the queue in one answer."""


def cut(text: str, most: int) -> str:
    """Return a text of at most `most` characters, with a mark in place of what is missing."""
    if len(text) <= most:
        return text
    mark = f' … ({len(text)} characters, the rest is cut)'
    return text[: max(0, most - len(mark))] + mark


def fitting(things: Iterable[_T], most: int, size: Callable[[_T], int]) -> Iterator[_T]:
    """Yield things as long as they fit into a total size; the first one always."""
    total = 0
    for number, thing in enumerate(things):
        total += size(thing)
        if number and total > most:
            return
        yield thing


def listed(names: Collection[str], otherwise: str) -> str:
    """Return names for a message, not more than NAMES_LISTED; `otherwise` if there are none."""
    more = len(names) - NAMES_LISTED
    shown = ', '.join(islice(names, NAMES_LISTED)) or otherwise
    return f'{shown} and {more} more' if more > 0 else shown


def rough_size(value: Any) -> int:
    """Return about how many bytes a plain value takes as JSON, without making it."""
    if isinstance(value, str):
        return len(value) + 2
    if value is None or isinstance(value, (float, int)):  # a bool is one
        return 8
    if isinstance(value, Mapping):
        return sum(len(key) + 4 + rough_size(member) for key, member in value.items())
    if isinstance(value, (list, tuple)):
        return sum(map(rough_size, value)) + 2
    return 8


def shortened(value: Any, most: int) -> Any:
    """Return a plain value, or in its place a text if it is longer than about `most` bytes."""
    if isinstance(value, str):
        return cut(value, most)
    size = rough_size(value)
    return f'… ({size} bytes, too long to be shown)' if size > most else value


def without_longest(fields: Mapping[str, Any], most: int) -> dict[str, Any]:
    """Return fields without the longest ones, at most about `most` bytes in all."""
    sizes = {name: rough_size(value) for name, value in fields.items()}
    total = sum(sizes.values())
    if total <= most:
        return dict(fields)
    for name in sorted(sizes, key=lambda name: -sizes[name]):
        if total <= most:
            break
        total -= sizes.pop(name)
    return {name: value for name, value in fields.items() if name in sizes}


# Rate limits per sender: an allowance shrinks with use and recovers with time.

SENDERS = 200
"""Maximum number of senders with their own allowance; all others share one."""


class Allowance:
    """The rest of a share. All times are of a steady clock."""

    def __init__(self, share: Share) -> None:
        self._share = share
        self._left = share.at_once
        self._at = -math.inf

    def left(self, now: float) -> float:
        """Return how much may be used now; below 0: overdrawn."""
        grown = self._left + self._share.per_s * (now - self._at)
        self._left, self._at = min(self._share.at_once, grown), now
        return self._left

    def use(self, amount: float, now: float) -> None:
        """Subtract what was used."""
        self._left = self.left(now) - amount

    def is_full(self, now: float) -> bool:
        """Tell whether it has recovered completely."""
        return self.left(now) >= self._share.at_once


class Allowances:
    """One allowance for each sender, and one for all together.

    Senders choose their names: one that changes its name with each request still has only the
    common share.
    """

    def __init__(self, each: Share, together: Share) -> None:
        self._each = each
        self._together = Allowance(together)
        self._own: dict[Hashable, Allowance] = {}
        self._others = Allowance(each)

    def left(self, sender: Hashable, now: float) -> float:
        """Return how much a sender may use now."""
        return min(self._of(sender, now).left(now), self._together.left(now))

    def use(self, sender: Hashable, amount: float, now: float) -> None:
        """Subtract what a sender used."""
        self._of(sender, now).use(amount, now)
        self._together.use(amount, now)

    def _of(self, sender: Hashable, now: float) -> Allowance:
        if sender not in self._own and len(self._own) >= SENDERS:
            self._own = {who: own for who, own in self._own.items() if not own.is_full(now)}
            if len(self._own) >= SENDERS:
                return self._others
        return self._own.setdefault(sender, Allowance(self._each))
