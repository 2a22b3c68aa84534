"""The rights of users: four roles, and the requests of `model.requests` that each may make."""

from __future__ import annotations

from enum import Enum


class Role(Enum):
    """The role of a user."""

    VIEW = 'view'
    """Reads status, events, reports, the past; makes no requests."""
    MES = 'mes'
    """Manages the queue, as an MES does; answers no hold and starts no cell."""
    OPERATE = 'operate'
    """Works at the line."""
    ENGINEER = 'engineer'
    """May do everything."""
