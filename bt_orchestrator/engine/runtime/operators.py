"""Operators' decisions about holds and items (semantics 7.1)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import chain
from typing import Any

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.engine.runtime.deciding import Decided, decides
from bt_orchestrator.model import effects
from bt_orchestrator.model import events as e
from bt_orchestrator.model.by import Role
from bt_orchestrator.model.cell import OnFailure
from bt_orchestrator.model.failures import (
    ABORT_JOB,
    AGAIN,
    CHANGE,
    MARK_DONE,
    REJECT,
    RETRY,
    SKIP,
    abort_all_on_the_belt,
    begin_round,
    pass_over,
)
from bt_orchestrator.model.hold_words import hold_name
from bt_orchestrator.model.jobs.setups import changes_for
from bt_orchestrator.model.judging.results import serial_in, too_long
from bt_orchestrator.model.limits import listed
from bt_orchestrator.model.requests import (
    ACKNOWLEDGE,
    ANSWERS,
    CLASSIFY,
    COMMENT,
    REMOVE_ITEM,
    Asked,
)
from bt_orchestrator.model.requests.offers import allowed, answers_of_others
from bt_orchestrator.model.state import CellState, Hold, Phase
from bt_orchestrator.model.stop_reason import release_command
from bt_orchestrator.model.words import joined, sentence


@decides(*ANSWERS.values())
def _answer(state: CellState, asked: Asked, now: float) -> Decided:
    """Answer a hold.

    :raises CommandRefused: there is no such hold, or it does not offer that answer
    """
    hold = offering(state, asked['hold'], asked.request.word, asked.sender.role)
    _check_results(state, hold, asked)
    return _words(asked), _follows(state, asked, hold, now)


@decides(ACKNOWLEDGE, COMMENT)
def _remark(state: CellState, asked: Asked, _: float) -> Decided:
    """Record a remark about a hold, which changes nothing."""
    _standing(state, asked['hold'])
    return _words(asked), ()


@decides(CLASSIFY)
def _classify(_: CellState, asked: Asked, __: float) -> Decided:
    """Record the reason of a stop, which changes nothing (semantics 7.10)."""
    return sentence('classified', code=asked['code']), ()


def _words(asked: Asked) -> str:
    return sentence('answered', hold=asked['hold'], answer=asked.request.word)


def _follows(state: CellState, asked: Asked, hold: Hold, now: float) -> Iterator[e.Event]:
    word = asked.request.word
    if hold.key == e.INDEX_KEY and word == OnFailure.ABORT_JOB.value:
        # The move stays held (3.5).
        yield from abort_all_on_the_belt(state, _decision(asked))
        return
    yield e.HoldReleased(hold=hold.id)
    assert hold.key is not None
    yield from _ANSWERS[word](state, hold.key, asked, now)


@decides(REMOVE_ITEM)
def _remove(state: CellState, asked: Asked, _: float) -> Decided:
    """Take an item off the belt by hand; it leaves an empty position.

    :raises CommandRefused: the item is not on the belt
    """
    name = asked['item']
    item = state.items.get(name)
    if item is None or not item.section or not item.present:
        standing = [s.slot for s in state.sections.values() if s.slot is not None]
        present = listed([name for name in standing if state.items[name].present], 'nothing')
        raise CommandRefused(sentence('not_on_belt', item=name, items=present))
    removed = e.ItemRemoved(job=item.job, item=item.id, section=item.section, how='by_hand')
    return sentence('item_off', item=name), chain([removed], released_with(state, item.id))


def released_with(state: CellState, item: str) -> Iterator[e.HoldReleased]:
    """Release the holds that existed only because of the removed item (semantics 3.6)."""
    for hold in [h for h in state.holds.values() if h.item == item and h.task is None]:
        yield e.HoldReleased(hold=hold.id)


def _standing(state: CellState, name: str) -> Hold:
    hold = state.holds.get(name)
    if hold is None:
        there = listed(state.holds, 'none')
        raise CommandRefused(sentence('no_hold', hold=name, holds=there))
    return hold


def offering(state: CellState, name: str, word: str, role: Role) -> Hold:
    """Return a hold that offers an answer.

    :raises CommandRefused: there is no such hold, or it does not offer it; says what it offers
    """
    hold = _standing(state, name)
    held = hold_name(hold)
    if hold.is_pause:
        raise CommandRefused(sentence('takes_none', held=held, command=release_command(hold.id)))
    if hold.task is None:
        raise CommandRefused(sentence('takes_removal', held=held, item=hold.item))
    if word not in hold.answers:
        mine = ', '.join(allowed(hold.answers, role))
        others = joined(*answers_of_others(hold.answers, role))
        kind = 'answers_are_also' if others else 'answers_are'
        kind = kind if mine else 'answers_of_others'
        values = {'held': held, 'replies': mine, 'words': others, 'found': repr(word)}
        raise CommandRefused(sentence(kind, **values))
    return hold


def _check_results(state: CellState, hold: Hold, asked: Asked) -> None:
    """Refuse results of no item, and a serial that is no name.

    A serial in the history is a person's word (semantics 6.8).
    """
    results = _results(asked)
    if results and hold.item is None:
        answer = asked.request.word
        raise CommandRefused(sentence('results_of_item', answer=answer, task=hold.key))
    task = state.task(hold.key) if hold.key is not None else None
    problem = too_long(serial_in(task, results)) if task is not None else ''
    if problem:
        raise CommandRefused(problem)


def _results(asked: Asked) -> Mapping[str, Any]:
    results: Mapping[str, Any] = asked.arguments.get('results', {})
    return results


def _decision(asked: Asked) -> str:
    """Return who decided what, and why."""
    return asked.sender.deciding(asked.request.word)


def _retry(state: CellState, key: e.TaskKey, _: Asked, now: float) -> Iterator[e.Event]:
    attempt = state.tasks[key].attempt + 1
    yield e.TaskRetrying(**key._asdict(), attempt=attempt, not_before=now)


def _again(state: CellState, key: e.TaskKey, _: Asked, __: float) -> Iterator[e.Event]:
    yield begin_round(state, key)


def _change(state: CellState, key: e.TaskKey, asked: Asked, now: float) -> Iterator[e.Event]:
    """Do the change that a task lacks, then the task (semantics 5.3)."""
    task = state.task(key)
    assert task is not None
    for change in changes_for(state, key, task):
        if state.phase(change) is Phase.DONE:
            yield from _retry(state, change, asked, now)
    yield from _retry(state, key, asked, now)


def _mark_done(state: CellState, key: e.TaskKey, asked: Asked, _: float) -> Iterator[e.Event]:
    yield from _without_verdict(state, key, asked)
    yield e.TaskMarkedDone(**key._asdict(), results=_results(asked))
    yield from effects.of_success(state, key)


def _skip(state: CellState, key: e.TaskKey, asked: Asked, _: float) -> Iterator[e.Event]:
    yield from _without_verdict(state, key, asked)
    yield e.TaskSkipped(**key._asdict(), reason=_decision(asked))
    yield from effects.of_passing(state, key)


def _without_verdict(
    state: CellState, key: e.TaskKey, asked: Asked
) -> Iterator[e.ItemNonconforming]:
    """Mark an item that passes a task although its verdict does not say so (semantics 2.8)."""
    task = state.task(key)
    if task is None or task.fails_unless is None or key.job is None or key.item is None:
        return
    if state.items[key.item].present:
        reason = _decision(asked)
        yield e.ItemNonconforming(job=key.job, item=key.item, task=key.task, reason=reason)


def _reject(state: CellState, key: e.TaskKey, asked: Asked, _: float) -> Iterator[e.Event]:
    yield from pass_over(state, key, OnFailure.REJECT, _decision(asked))


def _abort_job(state: CellState, key: e.TaskKey, asked: Asked, _: float) -> Iterator[e.Event]:
    yield from pass_over(state, key, OnFailure.ABORT_JOB, _decision(asked))


_ANSWERS = {
    RETRY: _retry,
    AGAIN: _again,
    CHANGE: _change,
    MARK_DONE: _mark_done,
    SKIP: _skip,
    REJECT: _reject,
    ABORT_JOB: _abort_job,
}
