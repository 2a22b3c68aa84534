"""How the threads of the page end."""

from __future__ import annotations

FAREWELL_S = 1.0
"""Longest wait for a thread: the middleware may hang, and the page ends all the same."""


class Ending(Exception):
    """The page ends."""
