"""From the value of a goal's `task` field back to the name of its constant."""

from __future__ import annotations

from typing import Any

from bt_orchestrator.model.action_type import ActionType
from bt_orchestrator.model.cell import Component


class TaskNames:
    """The tasks of one component, as its action server sees them.

    A type without a `task` field carries no name over the wire: its label is known here only if
    the cell file mentions exactly one for this component (in `durations` or `results`).
    """

    def __init__(self, component: Component, action_type: ActionType) -> None:
        mentioned = {*component.durations_s, *component.results}
        self._label = mentioned.pop() if len(mentioned) == 1 else ''
        self._has_task_field = action_type.has_task_field
        self._constants = dict(action_type.constants)
        # Several constants may share a value; the cell file tells which of them are tasks.
        preferred = sorted(self._constants, key=lambda name: name not in component.durations_s)
        self._by_value = {self._constants[name]: name for name in reversed(preferred)}

    def name(self, value: Any) -> str | None:
        """Return the name for a goal's task value; None if no constant has this value.

        :param value: of the goal's `task` field; ignored where the type has none
        """
        if not self._has_task_field:
            return self._label
        return self._by_value.get(value) if self._constants else str(value)
