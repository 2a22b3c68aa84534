"""Ann, who operates the line in the tests, and others who may do everything."""

from __future__ import annotations

from bt_orchestrator.model.by import By, Known, Role


def ann(reason: str = 'a test') -> By:
    """Return her, with a reason for what she commands."""
    return engineer('Ann', '', reason)


def engineer(who: str, origin: str = 'a test', reason: str = 'it is so') -> By:
    """Return somebody whose name is known."""
    return By(who, origin, reason, Role.ENGINEER, Known.LOCAL_USER)
