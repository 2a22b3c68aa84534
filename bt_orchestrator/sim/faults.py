"""Faults of simulated controllers: on the command line, and which strikes at each goal."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.model.cell import CONVEYOR, Cell, Component
from bt_orchestrator.model.fault import Fault, FaultKind, parse_fault
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.script.checks.faults import Unseen, unseen
from bt_orchestrator.script.report import did_you_mean, listing

_OPTION = re.compile(r'(?P<component>[\w-]+)\.?(?P<fault>.*)', re.DOTALL)


class WrongFaults(OrchestratorError):
    """Faults that do not fit the cell; one mistake a line."""


def with_faults(cell: Cell, options: Sequence[str], types: ActionTypes) -> Cell:
    """Return a cell whose components have these faults too.

    :param options: as users write them, `COMPONENT.[TASK][#NTH]=KIND[:SECONDS]`
    :raises WrongFaults: with everything that is wrong
    """
    components = dict(cell.components)
    mistakes = add_faults(components, cell, options, types)
    if mistakes:
        raise WrongFaults('\n'.join(mistakes))
    conveyor = replace(cell.conveyor, component=components[CONVEYOR])
    return replace(cell, conveyor=conveyor, components=components)


def add_faults(
    chosen: dict[str, Component], cell: Cell, options: Sequence[str], types: ActionTypes
) -> list[str]:
    """Give faults to the components chosen from a cell, beside those they have.

    :return: the options that are wrong, and why
    """
    mistakes = []
    for option in options:
        try:
            component, fault = _read(option, cell, chosen)
        except ValueError as error:
            mistakes.append(f'--fail {option}: {error}')
            continue
        reasons = list(_reasons(fault, component, types))
        mistakes += [f'--fail {option}: {reason.what}; {reason.hint}' for reason in reasons]
        if not reasons:
            chosen[component.name] = replace(component, faults=(*component.faults, fault))
    return mistakes


def unknown_component(name: str, cell: Cell) -> str:
    """Say that a cell has no component of that name, and which one was meant."""
    hint = did_you_mean(name, cell.components, f'the cell has {listing(cell.components)}')
    return f'no component `{name}` in cell `{cell.name}`; {hint}'


def _read(option: str, cell: Cell, chosen: Mapping[str, Component]) -> tuple[Component, Fault]:
    match = _OPTION.fullmatch(option.strip())
    if match is None:
        raise ValueError('expected COMPONENT.FAULT, as in arm.TASK_A#2=abort')
    name = match['component']
    if name not in cell.components:
        raise ValueError(unknown_component(name, cell))
    if name not in chosen:
        raise ValueError(f'component `{name}` is not simulated here; add it to --only')
    return chosen[name], parse_fault(match['fault'])


def _reasons(fault: Fault, component: Component, types: ActionTypes) -> Iterator[Unseen]:
    """Yield why a fault could never be seen."""
    return unseen(
        fault,
        component.name,
        types.action(component.type),
        has_state=component.state is not None,
    )


# The fault that strikes at each goal of one simulated controller.


@dataclass(frozen=True)
class GoalFaults:
    """The faults that strike at one goal; of several of one sort the first one listed counts."""

    faults: tuple[Fault, ...] = ()
    goal: int = 0
    """The number of the goal of the component, from 1."""

    def has(self, kind: FaultKind) -> bool:
        """Tell whether a fault of this kind strikes."""
        return self.find(kind) is not None

    def find(self, *kinds: FaultKind) -> Fault | None:
        """Return the first fault of these kinds."""
        if not self.faults:
            return None
        return next((fault for fault in self.faults if fault.kind in kinds), None)

    @property
    def late_s(self) -> float:
        """Seconds beyond the nominal duration."""
        late = self.find(FaultKind.LATE)
        return late.seconds or 0.0 if late else 0.0


class FaultSchedule:
    """Counts the goals of one component.

    The count belongs to the simulation, not to the server: a server that died and came back knows
    nothing, yet its next goal is not the first one again.
    """

    def __init__(self, faults: Sequence[Fault]) -> None:
        self._faults = tuple(faults)
        self._count = 0
        self._count_of_task: Counter[str] = Counter()

    def at_start(self, kind: FaultKind) -> Fault | None:
        """Return the fault of this kind that is there from the start (`#0`)."""
        return next((f for f in self._faults if f.nth == 0 and f.kind is kind), None)

    def next_goal(self, task: str) -> GoalFaults:
        """Count one more goal of a task and return what strikes at it."""
        self._count += 1
        if not self._faults:
            return GoalFaults(goal=self._count)
        self._count_of_task[task] += 1
        counts = self._count, self._count_of_task[task]
        striking = tuple(f for f in self._faults if f.strikes(task, *counts))
        return GoalFaults(striking, self._count)
