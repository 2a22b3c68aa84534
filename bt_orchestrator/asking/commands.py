"""Requests as commands to the engine, and the refusal of each that makes none."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

from bt_orchestrator.errors import CommandRefused
from bt_orchestrator.model import cell_commands as c
from bt_orchestrator.model.belt_statement import AsShown, Statement, parse_slots
from bt_orchestrator.model.by import By
from bt_orchestrator.model.commands import (
    AnswerHold,
    Command,
    ReleaseScript,
    RemoveItem,
    SetService,
)
from bt_orchestrator.model.jobs.job_commands import ControlJob, MoveJob, RunNext, StopAfter
from bt_orchestrator.model.packml import VERBS, Cause
from bt_orchestrator.model.requests import (
    IN_SERVICE,
    MOVE,
    NEXT,
    About,
    Asked,
    of_word,
    words_about,
)
from bt_orchestrator.model.script import Task
from bt_orchestrator.model.state import CellState
from bt_orchestrator.model.wish import STOP_AFTER
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.script.given_results import given_results, results_text
from bt_orchestrator.script.report import did_you_mean, listing

Arguments = Mapping[str, Any]
"""By the names of `model.requests`; those that were not said are left out, or None, or empty."""


def command_of(asked: Asked, state: CellState, types: ActionTypes) -> Command:
    """Return the command of a request that is not about orders (`asking.orders`).

    :raises CommandRefused: says what was expected
    """
    about, word = asked.request.about, asked.request.word
    return command(about, word, asked.by, asked.arguments, state, types)


def command(
    about: About, word: str, by: By, given: Arguments, state: CellState, types: ActionTypes
) -> Command:
    """Return the command of a request that came as words, as `command_of` does.

    A word that the table of requests does not have is refused here, or by the engine.

    :raises CommandRefused: says what was expected
    """
    match about:
        case About.CELL:
            return _to_cell(word, by, given)
        case About.JOB:
            return _to_job(word, by, given)
        case About.ITEM:
            return RemoveItem(given['item'], by)
        case About.HOLD:
            return AnswerHold(given['hold'], word, by, _results(given, state, types))
        case About.COMPONENT:
            return _to_component(word, by, given, state)
        case About.SCRIPT:
            return _to_script(word, by, given, state)
        case About.QUEUE:
            raise AssertionError(f'{word} is about orders, which have to be read first')


# --- the cell -----------------------------------------------------------------------------------


def _to_cell(word: str, by: By, given: Arguments) -> Command:
    if word.startswith(STOP_AFTER):
        return StopAfter(word.removeprefix(STOP_AFTER), by)
    make = _TO_CELL.get(word)
    if make is None:
        others = (*words_about(About.COMPONENT), *words_about(About.SCRIPT))
        known = ', '.join((*_TO_CELL, *others))
        raise CommandRefused(f'unknown command {word!r}; one of {known}')
    return make(by, given)


def _resume(by: By, given: Arguments) -> c.Resume:
    return c.Resume(
        by, hold=given.get('hold') or None, everyones=bool(given.get('everyones', False))
    )


def _clear(by: By, given: Arguments) -> c.Clear:
    return c.Clear(by, belt=_statement(given.get('belt'), given.get('as_shown')))


def _statement(belt: Any, as_shown: Any) -> Statement:
    if bool(belt) == bool(as_shown):
        raise CommandRefused(
            'clear needs to know what stands on the belt: either every slot, as in 1=WO-1/3 and '
            '2=empty, or the seq of the status that shows the belt as it is'
        )
    return parse_slots(belt) if belt else AsShown(as_shown)


_TO_CELL: Mapping[str, Callable[[By, Arguments], c.CellCommand]] = {
    VERBS[Cause.RESET]: lambda by, _: c.Reset(by),
    VERBS[Cause.START]: lambda by, _: c.Start(by),
    VERBS[Cause.HOLD]: lambda by, _: c.Pause(by),
    VERBS[Cause.UNHOLD]: _resume,
    VERBS[Cause.STOP]: lambda by, _: c.Stop(by),
    VERBS[Cause.ABORT]: lambda by, _: c.Abort(by),
    VERBS[Cause.CLEAR]: _clear,
}


def _to_component(word: str, by: By, given: Arguments, state: CellState) -> SetService:
    request, name = of_word(About.COMPONENT, word), given['component']
    if request is None:
        known = ', '.join(words_about(About.COMPONENT))
        raise CommandRefused(f'unknown command {word!r} to a component; one of {known}')
    components = {**state.cell.components, **state.out_of_service}
    if name not in components:
        hint = did_you_mean(name, components, f'the cell has {listing(components)}')
        raise CommandRefused(f'there is no component {name!r}; {hint}')
    return SetService(name, request == IN_SERVICE, by)


# --- scripts ------------------------------------------------------------------------------------

_DIGEST = re.compile('[0-9a-f]{12}')


def _to_script(word: str, by: By, given: Arguments, state: CellState) -> ReleaseScript:
    if of_word(About.SCRIPT, word) is None:
        known = ', '.join(words_about(About.SCRIPT))
        raise CommandRefused(f'unknown command {word!r} to a script; one of {known}')
    script = _digest_of(given['script'], state)
    return ReleaseScript(script, by, given.get('cell_digest') or '')


def _digest_of(script: str, state: CellState) -> str:
    """Return the digest of a script that is named by it, or that queued jobs wait for."""
    if _DIGEST.fullmatch(script):
        return script
    waiting = {job.digest: job.job.script.name for job in state.queue if job.awaits_release}
    found = [digest for digest, name in waiting.items() if name == script]
    if len(found) == 1:
        return found[0]
    told = [f'{name} ({digest})' for digest, name in waiting.items()]
    what = 'several scripts are called' if found else 'no job in the queue waits for'
    raise CommandRefused(
        f'{what} {script!r}; name the digest of one; jobs wait for '
        f'{listing(told) if told else "no script"}'
    )


# --- jobs and holds -----------------------------------------------------------------------------


def _to_job(word: str, by: By, given: Arguments) -> Command:
    job = given['job']
    if word == MOVE.word:
        if given.get('position') is None:
            raise CommandRefused(f'to move {job}, name its new position, from 1')
        return MoveJob(job, given['position'], by)
    return RunNext(job, by) if word == NEXT.word else ControlJob(word, job, by)


def _results(given: Arguments, state: CellState, types: ActionTypes) -> Mapping[str, Any]:
    """Return the results that are given with an answer, as values of their types.

    :raises CommandRefused: they are none of the task that is held
    """
    results = given.get('results')
    if not results:
        return {}
    hold = state.holds.get(given['hold'])
    task = state.task(hold.key) if hold is not None and hold.key is not None else None
    if task is None:
        raise CommandRefused(
            f'hold {given["hold"]} is about no task that can have results; answer it without'
        )
    text = results if isinstance(results, str) else results_text(results)
    return given_results(text, types.action(_type_of(state, task)))


def _type_of(state: CellState, task: Task) -> str:
    return state.cell.components[task.component].type
