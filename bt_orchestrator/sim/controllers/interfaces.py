"""The ROS 2 message classes that are needed here; the entry point hands them in."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol


class Interfaces(Protocol):
    """The installed message and action classes, and how they are filled."""

    def action_class(self, name: str) -> Any:
        """Return the class of an action type such as pkg/action/Name."""

    def message_class(self, name: str) -> Any:
        """Return the class of a message type such as pkg/msg/Name."""

    def fill(self, message: Any, fields: Mapping[str, Any]) -> None:
        """Set fields from plain values; those of nested messages are mappings."""
