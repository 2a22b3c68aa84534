"""Setups of components: which changes a script implies, and what is known of them (semantics 5.3).

A change is a task. The ones that follow from what other tasks ask for stand in no text: they are
initialization tasks of the script that is bound to a cell.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from bt_orchestrator.model.cell import Cell, Component
from bt_orchestrator.model.events import TaskKey
from bt_orchestrator.model.line import is_ahead, is_done_with
from bt_orchestrator.model.script import (
    InitializationDependency,
    Script,
    SetupChange,
    Task,
)
from bt_orchestrator.model.state import CellState, JobState, KnownSetup, Phase, SectionState
from bt_orchestrator.model.words import sentence


def change_id(component: str, setup: str, value: str) -> str:
    """Return the id of an implied change."""
    return f'{component}.{setup}.{value}'


def change_by(component: Component, name: str, args: Mapping[str, Any]) -> SetupChange | None:
    """Return what a task of a component changes; None: nothing, or to no value that it has."""
    for setup, made in component.setups.items():
        if made.task == name:
            given = args.get(made.argument)
            values = [value for value, argument in made.values.items() if argument == given]
            return SetupChange(setup, values[0]) if values else None
    return None


# --- scripts ------------------------------------------------------------------------------------


class _Wanted(NamedTuple):
    component: str
    setup: str
    value: str


def with_changes(script: Script, cell: Cell) -> Script:
    """Return a script with the changes that its tasks imply, behind its own initialization."""
    wanted = _wanted(script)
    if not wanted:
        return script
    changes = tuple(_change(wish, cell, on_demand=late) for wish, late in wanted.items())
    order = tuple(
        InitializationDependency(own.id, change.id)
        for change in changes
        for own in script.initialization
        if own.component == change.component
    )
    return replace(
        script,
        initialization=(*script.initialization, *changes),
        initialization_dependencies=(*script.initialization_dependencies, *order),
    )


def _wanted(script: Script) -> dict[_Wanted, bool]:
    """Return each value that a task asks for, and whether a task changes the setup before."""
    wanted: dict[_Wanted, bool] = {}
    for number in sorted(script.sections):
        before: set[tuple[str, str]] = set()
        for task in script.sections[number].tasks:
            for setup, value in task.setup.items():
                wish = _Wanted(task.component, setup, value)
                wanted[wish] = wanted.get(wish, True) and (task.component, setup) in before
                before.add((task.component, setup))
            if task.change is not None:
                before.add((task.component, task.change.setup))
    return wanted


def _change(wanted: _Wanted, cell: Cell, *, on_demand: bool) -> Task:
    component = cell.components[wanted.component]
    made = component.setups[wanted.setup]
    return Task(
        id=change_id(*wanted),
        name=made.task,
        action=component.action,
        component=component.name,
        args={made.argument: made.values[wanted.value]},
        timeout_s=component.timeout_s,
        once=True,
        change=SetupChange(wanted.setup, wanted.value, implied=True, on_demand=on_demand),
    )


# --- what is known ------------------------------------------------------------------------------


def known(state: CellState, component: str, setup: str) -> str | None:
    """Return the present value of a setup; None: it is not known.

    What a state topic tells counts before everything else; it may be none of the values.
    """
    if _is_read(state, component, setup):
        return state.setups_told.get(component, {}).get(setup) or None
    entry = state.setups.get(component, {}).get(setup)
    return None if entry is None else entry.value


def _is_read(state: CellState, component: str, setup: str) -> bool:
    """Tell whether the state topic of a component tells a setup; not so in an older cell."""
    made = state.cell.components[component].setups.get(setup)
    return made is not None and bool(made.reads)


def untold(state: CellState, task: Task) -> tuple[str, str] | None:
    """Return the setup that the topic of a component does not tell as a task asks for it.

    With what the topic says, empty: nothing. None: there is no such setup.
    """
    for setup, wanted in task.setup.items():
        if _is_read(state, task.component, setup):
            value = known(state, task.component, setup)
            if value != wanted:
                return setup, value or ''
    return None


def missing_setup(state: CellState, task: Task) -> str | None:
    """Say which setup of its component keeps a task from its goal; None: it may be sent."""
    for setup, wanted in task.setup.items():
        value = known(state, task.component, setup)
        if value != wanted:
            kind = 'setup_unknown' if value is None else 'setup_other'
            names = {'component': task.component, 'setup': setup, 'wanted': wanted}
            return sentence(kind, **names, found=value)
    return None


def changes_for(state: CellState, key: TaskKey, task: Task) -> Iterator[TaskKey]:
    """Yield the changes that a task lacks: initialization tasks of its job."""
    for setup, wanted in task.setup.items():
        if known(state, task.component, setup) != wanted:
            yield TaskKey(key.job, None, None, change_id(task.component, setup, wanted))


def why_needless(state: CellState, key: TaskKey, change: Task) -> str | None:
    """Say why an implied change is not needed; None: it is."""
    made = change.change
    assert made is not None
    if known(state, change.component, made.setup) == made.value:
        return 'set up'
    return 'not asked for' if made.on_demand and state.phase(key) is None else None


def stays(state: CellState, job: JobState, before: Sequence[JobState], task: Task) -> bool:
    """Tell whether neither a job nor those before it change a setup before an implied change."""
    return not any(
        other.component == task.component and _changes(other, task)
        for earlier in (*before, job)
        for other in _to_come(state, earlier, whole=earlier is not job)
        if earlier is not job or other.id != task.id
    )


def _changes(other: Task, task: Task) -> bool:
    assert task.change is not None
    return other.change is not None and other.change.setup == task.change.setup


def _to_come(state: CellState, job: JobState, *, whole: bool) -> Iterator[Task]:
    """Yield the tasks that a job may still do: initialization, and the lists of its sections."""
    for task in job.job.script.initialization:
        phase = state.phase(TaskKey(job.job.id, None, None, task.id))
        is_asked = phase is not None or task.change is None or not task.change.on_demand
        if phase is not Phase.DONE and is_asked:
            yield task
    for number, tasks in job.job.script.sections.items():
        if whole and not is_done_with(state, state.sections[number], job):
            yield from tasks.tasks


# --- changes of what is known -------------------------------------------------------------------


def learn(state: CellState, task: Task, server: str | None) -> None:
    """Keep what a change has set."""
    assert task.change is not None
    setup, value = task.change.setup, task.change.value
    if _is_read(state, task.component, setup):
        now = KnownSetup(value, is_told=known(state, task.component, setup) == value)
    else:
        now = KnownSetup(value, server)
    state.setups.setdefault(task.component, {})[setup] = now


def note_told(state: CellState, component: str, setup: str, value: str | None) -> None:
    """Keep what a state topic tells; where a told value is another one now, changes are evaluated.

    A topic may tell a change a moment after its success: until then it has not told another value.

    :param value: None: the topic says nothing
    """
    setups = state.setups_told.setdefault(component, {})
    if value is None:
        setups.pop(setup, None)
        return
    setups[setup] = value
    before = state.setups.get(component, {}).get(setup)
    is_other = before is not None and before.value != value
    if before is not None and is_other and not before.is_told:
        return
    state.setups.setdefault(component, {})[setup] = KnownSetup(value, is_told=True)
    if is_other:
        _evaluate_again(state, component, [setup], but=value)


def forget(state: CellState, component: str, setup: str) -> None:
    """Forget the value of one setup."""
    of_component = state.setups.get(component, {})
    of_component.pop(setup, None)
    if not of_component:
        state.setups.pop(component, None)


def forget_all(state: CellState, component: str | None = None) -> None:
    """Forget the setups of a component, or of all; jobs that have not begun there change anew.

    :param component: None: all of them
    """
    for name in [component] if component is not None else list(state.setups):
        known_there = state.setups.get(name, {})
        lost = [setup for setup in known_there if not _is_read(state, name, setup)]
        for setup in lost:
            forget(state, name, setup)
        if lost:
            _evaluate_again(state, name, lost)


def _evaluate_again(
    state: CellState, component: str, setups: Collection[str], but: str | None = None
) -> None:
    """Evaluate changes of setups again for the jobs whose first task there is to come.

    :param but: changes to this value stay as they are
    """
    for key, progress in list(state.tasks.items()):
        if progress.phase is not Phase.DONE or key.section is not None or key.job is None:
            continue
        task = state.task(key)
        if task is None or not task.is_implied or task.component != component:
            continue
        change = task.change
        if change is None or change.setup not in setups or change.value == but:
            continue
        numbers = state.preparations[state.jobs[key.job].digest].sections[task.id]
        if not any(_has_begun(state, state.sections[n], state.jobs[key.job]) for n in numbers):
            del state.tasks[key]


def _has_begun(state: CellState, section: SectionState, job: JobState) -> bool:
    """Tell whether a section has begun a cycle of a job."""
    if section.cycle is not None and section.cycle.job == job.job.id:
        return True
    if section.number == job.job.script.source:
        return job.progress.started > 0
    to_come = sum(is_ahead(state, section, item.section, job) for item in job.items.values())
    return to_come < job.progress.started
