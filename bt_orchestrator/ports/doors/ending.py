"""How the threads with the doors end."""

from __future__ import annotations

FAREWELL_S = 1.0
"""Longest wait for a thread: the middleware may hang, and the program ends all the same."""


class Ending(Exception):
    """The program ends."""
