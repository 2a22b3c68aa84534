"""Who may do what: four roles, and the requests of `model.requests` that each may make."""

from __future__ import annotations

from enum import Enum


class Role(Enum):
    """What somebody who asks is there for."""

    VIEW = 'view'
    """Reads status, events, reports, the past; asks nothing."""
    MES = 'mes'
    """Keeps the queue, as an MES does; answers no hold and starts no cell."""
    OPERATE = 'operate'
    """Works at the line."""
    ENGINEER = 'engineer'
    """May do everything."""
