"""Which components of a cell are simulated, and with which faults."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from bt_orchestrator.errors import OrchestratorError
from bt_orchestrator.model.action_type import TASK_RESULT, ActionType
from bt_orchestrator.model.cell import Cell, Component
from bt_orchestrator.model.fault import Fault, FaultKind, parse_fault
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.script.report import did_you_mean, listing

_OF_STATE = (FaultKind.NOT_READY, FaultKind.SILENT)
_COMPONENT = re.compile(r'(?P<component>[\w-]+)\.?(?P<fault>.*)', re.DOTALL)


class WrongSelection(OrchestratorError):
    """What was chosen on the command line does not fit the cell."""


def select(
    cell: Cell, only: Sequence[str], faults: Sequence[str], types: ActionTypes
) -> list[Component]:
    """Return the components to simulate, in the order of the cell file.

    :param only: names of components; none of them means all
    :param faults: as users write them, `COMPONENT.[TASK][#NTH]=KIND[:SECONDS]`; they add to those
        of the cell file
    :raises WrongSelection: with everything that is wrong, one mistake a line
    """
    mistakes = [
        f'--only {name}: {_unknown(name, cell)}' for name in only if name not in cell.components
    ]
    chosen = {name: c for name, c in cell.components.items() if not only or name in only}
    for text in faults:
        try:
            component, fault = _read(text, cell, chosen)
            _check(fault, component, types.action(component.type))
        except ValueError as error:
            mistakes.append(f'--fail {text}: {error}')
        else:
            chosen[component.name] = replace(component, faults=(*component.faults, fault))
    if mistakes:
        raise WrongSelection('\n'.join(mistakes))
    return list(chosen.values())


def names(texts: Sequence[str]) -> Iterator[str]:
    """Yield the names in comma-separated lists."""
    return (name.strip() for text in texts for name in text.split(',') if name.strip())


def _read(text: str, cell: Cell, chosen: Mapping[str, Component]) -> tuple[Component, Fault]:
    match = _COMPONENT.fullmatch(text.strip())
    if match is None:
        raise ValueError('expected COMPONENT.FAULT, as in arm.TASK_A#2=abort')
    name = match['component']
    if name not in cell.components:
        raise ValueError(_unknown(name, cell))
    if name not in chosen:
        raise ValueError(f'component `{name}` is not simulated here; add it to --only')
    return chosen[name], parse_fault(match['fault'])


def _check(fault: Fault, component: Component, action_type: ActionType) -> None:
    """Refuse a fault that could never be seen."""
    if fault.task is not None:
        _check_task(fault.task, component, action_type)
    if fault.kind in _OF_STATE and component.state is None:
        raise ValueError(f'component `{component.name}` has no state topic in the cell file')
    if fault.kind is FaultKind.FALSE and TASK_RESULT not in action_type.result.fields:
        raise ValueError(f'the Result of {action_type.name} has no field `{TASK_RESULT}`')


def _check_task(task: str, component: Component, action_type: ActionType) -> None:
    if not action_type.has_task_field:
        what = f'{action_type.name} has no task field, its goals cannot be told apart'
        raise ValueError(f'{what}; leave the task out: {component.name}.#1=...')
    constants = action_type.constants
    if task not in constants and constants:
        hint = did_you_mean(task, constants, f'its tasks are {listing(constants)}')
        raise ValueError(f'{action_type.name} has no task `{task}`; {hint}')


def _unknown(name: str, cell: Cell) -> str:
    hint = did_you_mean(name, cell.components, f'the cell has {listing(cell.components)}')
    return f'no component `{name}` in cell `{cell.name}`; {hint}'
