"""Ann, who operates the line in the tests."""

from __future__ import annotations

from bt_orchestrator.model.by import By


def ann(reason: str = '') -> By:
    """Return her, with a reason for what she commands."""
    return By('Ann', '', reason)
