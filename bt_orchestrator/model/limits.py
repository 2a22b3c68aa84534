"""How much is taken in from outside, so that nobody fills the journal, a log or the memory.

What a request says and is longer is refused with a sentence; what a controller says is cut, with a
mark that tells how much is missing, for its goal has ended all the same.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass
from itertools import islice
from typing import TypeVar

_T = TypeVar('_T')

REQUEST_BYTES = 1_000_000
"""Longest request, all its texts together."""

FINDINGS = 100
"""Most mistakes that are listed in the answer to a request."""

WHO = 200
"""Longest name of who commands, in characters."""

ORIGIN = 200
"""Longest name of the place that a command comes from, in characters."""

REASON = 2_000
"""Longest reason for a command, in characters."""

NAME = 200
"""Longest name in a request: of a hold, a job, an item, a script, a word of command."""

MESSAGE = 2_000
"""Longest words about a failure that are kept, in characters."""

STATE_VALUE_BYTES = 64_000
"""Longest value of a state topic that is kept, as JSON."""

PAUSES = 32
"""Most pauses that stand at a time; a cell that has one starts nothing already."""

TWINS = 8
"""Most holds that stand at a time because of nodes of one name."""

EVENTS_BYTES = 1_000_000
"""Longest answer to a client that asks for events, as JSON; one event is always told."""

NAMES_LISTED = 20
"""Most names that a message lists."""


@dataclass(frozen=True)
class Share:
    """Bytes that may be written to the journal: so many at once, so many a second after that."""

    at_once: float
    per_s: float


COMMANDS_OF_ONE = Share(16e6, 2e3)
"""What the commands of one sender write. One work order writes about 600 bytes."""

COMMANDS = Share(32e6, 2e3)
"""What the commands of all senders write together."""

REFUSALS_OF_ONE = Share(16e3, 100.0)
"""What the single records of refused commands write, of one sender; others are counted."""

REFUSALS = Share(64e3, 300.0)
"""What the single records of refused commands write, of all senders together."""


QUEUE_SHOWN = 100
"""So many jobs of the queue are told of in a status, and are looked ahead at."""

QUEUE_PAGE = 500
"""Most jobs of the queue in one answer."""


def cut(text: str, most: int) -> str:
    """Return a text of at most `most` characters, with a mark in place of what is missing."""
    if len(text) <= most:
        return text
    mark = f' … ({len(text)} characters, the rest is cut)'
    return text[: max(0, most - len(mark))] + mark


def fitting(things: Iterable[_T], most: int, size: Callable[[_T], int]) -> Iterator[_T]:
    """Yield things for as long as they fit into a size together; the first one always."""
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
