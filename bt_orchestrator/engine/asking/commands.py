"""Requests as they are decided: with what has to be read or resolved for them first."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.engine.runtime.operators import offering
from bt_orchestrator.model.by import By
from bt_orchestrator.model.judging.belt_statement import AsShown, parse_slots
from bt_orchestrator.model.limits import cut
from bt_orchestrator.model.packml import Cause, UnitMode
from bt_orchestrator.model.plant.shifts import PlantReason
from bt_orchestrator.model.requests import (
    ANSWERS,
    CANCEL_TASK,
    CELL,
    CODE,
    IN_SERVICE,
    OUT_OF_SERVICE,
    RELEASE_SCRIPT,
    RUN_TASK,
    UNIT_MODES,
    About,
    Asked,
    Kind,
    Request,
    ask,
    of_name,
    refusal,
)
from bt_orchestrator.model.script import Task
from bt_orchestrator.model.state import CellState
from bt_orchestrator.model.words import joined, sentence
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.script.given_values import (
    arguments_of,
    given_goal,
    given_results,
    results_text,
)
from bt_orchestrator.script.report import did_you_mean, listing
from bt_orchestrator.script.task_names import wrong_task

Arguments = Mapping[str, Any]
"""By the names of `model.requests`; those that were not said are left out, or None, or empty."""

Prepare = Callable[[Asked, CellState, ActionTypes], dict[str, Any]]
"""Returns arguments that replace those of a request.

:raises CommandRefused: says what was expected
"""

PREPARES: dict[str, Prepare] = {}
"""By the name of the request; all others are decided as they come."""


def prepares(*requests: Request) -> Callable[[Prepare], Prepare]:
    """Make a function prepare some requests."""

    def register(prepare: Prepare) -> Prepare:
        PREPARES.update((request.name, prepare) for request in requests)
        return prepare

    return register


def prepared(asked: Asked, state: CellState, types: ActionTypes) -> Asked:
    """Return a request that can be decided; one without permission stays unchanged.

    :raises CommandRefused: says what was expected
    """
    prepare = PREPARES.get(asked.request.name)
    if prepare is None or refusal(asked.request, asked.sender, asked.arguments) is not None:
        return asked
    return replace(asked, arguments={**asked.arguments, **prepare(asked, state, types)})


def asked_by_name(name: str, by: By, given: Arguments, state: CellState) -> Asked:
    """Return a request that came by its name; values by name may come as one text.

    :raises CommandRefused: a hold has no such answer; a text is no mapping
    :raises BadArguments: there is no such request, or it has other arguments
    """
    about, _, word = name.partition('.')
    request = of_name(name)
    if request is None and about == About.HOLD.value:
        offering(state, str(given.get(about, '')), cut(word, 60), by.role)
    parameters = request.parameters if request is not None else ()
    values = [parameter.name for parameter in parameters if parameter.kind is Kind.VALUES]
    texts = {name: given[name] for name in values if isinstance(given.get(name), str)}
    return ask(name, by, **{**given, **{name: arguments_of(texts[name]) for name in texts}})


# The reasons of the plant for stops of the line (semantics 7.10).

_STOP_NAME = re.compile(r'(?P<history>[^:]*):(?P<seq>[0-9]{1,18})')


def unknown_code(asked: Asked, reasons: Mapping[str, PlantReason] | None) -> str:
    """Say why the code that comes with a request is no reason of the plant; empty: it is one.

    :param reasons: by code; None: the plant has no file of them
    """
    code = asked.arguments.get(CODE.name)
    if not code or (reasons is not None and code in reasons):
        return ''
    if reasons is None:
        return sentence('no_reasons', code=repr(code))
    hint = did_you_mean(code, reasons, sentence('plant_has', names=listing(reasons)))
    return sentence('no_such_reason', code=repr(code), words=hint)


def without_code(asked: Asked) -> Asked:
    """Return a request without the code of a reason."""
    given = {name: value for name, value in asked.arguments.items() if name != CODE.name}
    return replace(asked, arguments=given)


def stop_number(name: str, history: str) -> int:
    """Return the number of the event with which a stop began, from its name.

    :param history: of the journal
    :raises CommandRefused: it is none, or one of another journal
    """
    match = _STOP_NAME.fullmatch(name)
    if match is None:
        raise CommandRefused(sentence('stop_form', history=history, found=repr(name)))
    if match['history'] != history:
        raise CommandRefused(sentence('stop_elsewhere', name=name, history=history))
    return int(match['seq'])


@prepares(CELL[Cause.CLEAR], UNIT_MODES[UnitMode.PRODUCTION])
def _statement(asked: Asked, _: CellState, __: ActionTypes) -> dict[str, Any]:
    belt, as_shown = asked.arguments.get('belt'), asked.arguments.get('as_shown', 0)
    if bool(belt) == bool(as_shown):
        raise CommandRefused(sentence('statement', verb=asked.request.word))
    return {'belt': parse_slots(belt) if belt else AsShown(as_shown)}


@prepares(OUT_OF_SERVICE, IN_SERVICE, CANCEL_TASK)
def _component(asked: Asked, state: CellState, _: ActionTypes) -> dict[str, Any]:
    name, components = asked['component'], {**state.cell.components, **state.out_of_service}
    if name not in components:
        there = sentence('cell_has', components=listing(components))
        hint = did_you_mean(name, components, there)
        raise CommandRefused(joined(sentence('no_component', component=repr(name)), hint))
    return {}


@prepares(RUN_TASK)
def _goal(asked: Asked, state: CellState, types: ActionTypes) -> dict[str, Any]:
    """Read the fields of a goal as values of their types; the task has to be one of its type."""
    _component(asked, state, types)
    component = state.cell.components.get(asked['component'])
    if component is None:
        raise CommandRefused(sentence('component_gone', component=asked['component']))
    type_, task = types.action(component.type), asked['task']
    why_not = wrong_task(task, type_)
    if why_not:
        raise CommandRefused(why_not)
    args = asked.arguments.get('args')
    return {'args': given_goal(results_text(args), type_) if args else {}}


_DIGEST = re.compile('[0-9a-f]{12}')


@prepares(RELEASE_SCRIPT)
def _digest(asked: Asked, state: CellState, _: ActionTypes) -> dict[str, Any]:
    """Resolve a script that is named by its digest, or that queued jobs wait for."""
    script = asked['script']
    if _DIGEST.fullmatch(script):
        return {}
    waiting = {job.digest: job.job.script.name for job in state.queue if job.awaits_release}
    digests = [digest for digest, name in waiting.items() if name == script]
    if len(digests) == 1:
        return {'script': digests[0]}
    scripts = [f'{name} ({digest})' for digest, name in waiting.items()]
    kind = 'several_scripts' if digests else 'no_script_awaited'
    awaited = listing(scripts) if scripts else 'no script'
    raise CommandRefused(sentence(kind, script=repr(script), scripts=awaited))


@prepares(
    *(
        request
        for request in ANSWERS.values()
        if any(p.name == 'results' for p in request.parameters)
    )
)
def _results(asked: Asked, state: CellState, types: ActionTypes) -> dict[str, Any]:
    """Read the results that are given with an answer, as values of their types."""
    results = asked.arguments.get('results')
    if not results:
        return {'results': {}}
    hold = state.holds.get(asked['hold'])
    task = state.task(hold.key) if hold is not None and hold.key is not None else None
    if task is None:
        raise CommandRefused(sentence('no_results', hold=asked['hold']))
    text = results_text(results)
    return {'results': given_results(text, types.action(_type_of(state, task)))}


def _type_of(state: CellState, task: Task) -> str:
    return state.cell.components[task.component].type
