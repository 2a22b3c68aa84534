"""The description of a ROS 2 action type, as needed by checks and simulation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

Kind = Literal['bool', 'int', 'float', 'str', 'bytes', 'message']

TASK = 'task'
"""Goal field that selects what the component does (semantics 2.1)."""

TASK_RESULT = 'task_result'
"""Boolean Result field that says whether the task was done (semantics 2.2)."""


@dataclass(frozen=True)
class FieldType:
    """The type of one field."""

    kind: Kind
    ros_name: str
    """As ROS 2 writes it, for messages to a user: uint8, string<=10, float64[3]."""
    minimum: int | None = None
    maximum: int | None = None
    """Range of an integer."""
    is_array: bool = False
    array_length: int | None = None
    """Fixed length, or None."""
    array_maximum: int | None = None
    """Longest length of a bounded sequence, or None."""
    string_maximum: int | None = None
    """Longest length of a bounded string, or None."""
    message: MessageType | None = None
    """The nested message, for kind `message`."""


@dataclass(frozen=True)
class MessageType:
    """The fields of a message, in order."""

    name: str
    fields: Mapping[str, FieldType]


@dataclass(frozen=True)
class ActionType:
    """Goal, constants and result of one action type."""

    name: str
    """For example bt_orchestrator_interfaces/action/Conveyor."""
    goal: MessageType
    result: MessageType
    constants: Mapping[str, Any] = field(default_factory=dict)
    """Constants of the Goal by name."""

    @property
    def has_task_field(self) -> bool:
        """Tell whether the goal selects a task by a constant."""
        return TASK in self.goal.fields
