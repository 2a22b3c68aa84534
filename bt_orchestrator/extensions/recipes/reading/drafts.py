"""A recipe while it is being checked: operations with the places of their keys."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from bt_orchestrator.model.action_type import ActionType, FieldType, MessageType
from bt_orchestrator.model.cell import Capability
from bt_orchestrator.script.drafts import ScriptDraft, TaskDraft


class Candidate(NamedTuple):
    """A component that can do an operation."""

    component: str
    type: ActionType
    capability: Capability

    def __str__(self) -> str:
        return f'`{self.capability.name}` at `{self.component}`'

    def goal_field(self, name: str) -> FieldType:
        """Return the type of a field that the capability names."""
        return self.type.goal.fields[name]

    @property
    def given(self) -> Mapping[str, FieldType]:
        """Types of what it tells later operations."""
        fields = self.type.result.fields
        return {name: fields[field] for name, field in self.capability.gives.items()}


@dataclass(frozen=True)
class OperationDraft(TaskDraft):
    """One operation as far as it could be read.

    As a task it has those options that hold wherever it is done, and as its action's type what all
    candidates tell: it is not yet known which of them will do it.
    """

    does: tuple[str, ...] = ()
    """Capabilities, as written."""
    candidates: tuple[Candidate, ...] = ()
    """Empty: none is known, or `do` could not be read."""
    before: frozenset[str] = frozenset()
    """Ids of all operations that have ended before it starts."""
    after: tuple[str, ...] = ()
    """Ids of those directly before it."""

    @property
    def identifies(self) -> bool:
        """Tell whether its result may have the serial: it says so, or one that can do it does."""
        able = (candidate.capability.options for candidate in self.candidates)
        return super().identifies or any('identifies' in options for options in able)

    def precedes(self, other: TaskDraft) -> bool:
        """Tell whether it has ended before the other one starts."""
        return isinstance(other, OperationDraft) and self.id in other.before

    def may_precede(self, other: TaskDraft) -> bool:
        """Tell whether it has ended before the other one starts."""
        return self.precedes(other)

    def hint_to_precede(self, other: TaskDraft) -> str:
        """Say what to write at an operation beside it; empty: it is not beside it."""
        if not isinstance(other, OperationDraft) or not self.is_beside(other):
            return ''
        before = ', '.join((*other.after, self.id))
        return f'write `after: [{before}]` there'

    def is_beside(self, other: TaskDraft) -> bool:
        """Tell whether neither of two operations is before the other."""
        return other is not self and not self.precedes(other) and not other.precedes(self)


@dataclass
class RecipeDraft(ScriptDraft):
    """A recipe as far as it could be read."""

    kind: str = 'recipe'
    a_step: str = 'an operation'
    operations: list[OperationDraft] = field(default_factory=list)


def given_by_all(candidates: Sequence[Candidate], does: Sequence[str]) -> ActionType | None:
    """Return what every candidate tells, as the type of an action; None if there is none."""
    if not candidates:
        return None
    first, *others = (candidate.given for candidate in candidates)
    fields = {name: type_ for name, type_ in first.items() if all(name in o for o in others)}
    name = ' or '.join(f'`{one}`' for one in does)
    return ActionType(name, MessageType(name, {}), MessageType(name, fields))
