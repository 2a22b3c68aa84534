"""How much is taken in from outside, so that nobody fills the journal, a log or the memory.

What a request says and is longer is refused with a sentence; what a controller says is cut, with a
mark that tells how much is missing, for its goal has ended all the same.
"""

from __future__ import annotations

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


def cut(text: str, most: int) -> str:
    """Return a text of at most `most` characters, with a mark in place of what is missing."""
    if len(text) <= most:
        return text
    mark = f' … ({len(text)} characters, the rest is cut)'
    return text[: max(0, most - len(mark))] + mark
