"""Operators' decisions about holds and items (semantics 7.1)."""

from __future__ import annotations

from collections.abc import Iterator

from bt_orchestrator.errors import CommandRefused
from bt_orchestrator.model import effects
from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import OnFailure
from bt_orchestrator.model.commands import AnswerHold, RemoveItem
from bt_orchestrator.model.failures import (
    ABORT_JOB,
    AGAIN,
    MARK_DONE,
    REJECT,
    RETRY,
    SKIP,
    abort_all_on_the_belt,
    begin_round,
    pass_over,
)
from bt_orchestrator.model.hold_words import hold_name
from bt_orchestrator.model.judging.serials import serial_in, too_long
from bt_orchestrator.model.limits import listed
from bt_orchestrator.model.pauses import release_command
from bt_orchestrator.model.requests import REMARKS
from bt_orchestrator.model.requests.reader import offer_words
from bt_orchestrator.model.state import CellState, Hold
from bt_orchestrator.runtime.command_record import decided


def answer(state: CellState, command: AnswerHold, now: float) -> Iterator[e.Event]:
    """Answer a hold, or record a remark about it, which changes nothing.

    :raises CommandRefused: there is no such hold, or it does not offer that answer
    """
    if command.answer in REMARKS:
        yield from _remark(state, command)
        return
    hold = _offering(state, command)
    yield from decided(command)
    if hold.key == e.INDEX_KEY and command.answer == OnFailure.ABORT_JOB.value:
        # The move stays held (3.5).
        yield from abort_all_on_the_belt(state, command.by.deciding(command.answer))
        return
    yield e.HoldReleased(hold=hold.id)
    assert hold.key is not None
    yield from _ANSWERS[command.answer](state, hold.key, command, now)


def remove(state: CellState, command: RemoveItem) -> Iterator[e.Event]:
    """Take an item off the belt by hand; it leaves an empty position.

    :raises CommandRefused: the item is not on the belt
    """
    item = state.items.get(command.item)
    if item is None or not item.section or not item.present:
        standing = [s.slot for s in state.sections.values() if s.slot is not None]
        present = listed([name for name in standing if state.items[name].present], 'nothing')
        raise CommandRefused(f'{command.item} is not on the belt; on it: {present}')
    yield from decided(command)
    section = item.section
    yield e.ItemRemoved(job=item.job, item=item.id, section=section, how='by_hand')
    yield from released_with(state, item.id)


def released_with(state: CellState, item: str) -> Iterator[e.HoldReleased]:
    """Release the holds that existed only because of the removed item (semantics 3.6)."""
    for hold in [h for h in state.holds.values() if h.item == item and h.task is None]:
        yield e.HoldReleased(hold=hold.id)


def _remark(state: CellState, command: AnswerHold) -> Iterator[e.Event]:
    _standing(state, command)
    if command.results:
        raise CommandRefused(f'results are given with {MARK_DONE}; found {command.answer}')
    yield from decided(command)


def _standing(state: CellState, command: AnswerHold) -> Hold:
    hold = state.holds.get(command.hold)
    if hold is None:
        there = listed(state.holds, 'none')
        raise CommandRefused(f'there is no hold {command.hold}; holds now: {there}')
    return hold


def _offering(state: CellState, command: AnswerHold) -> Hold:
    hold = _standing(state, command)
    if hold.is_pause:
        raise CommandRefused(f'{hold_name(hold)} takes no answer; {release_command(hold.id)}')
    if hold.task is None:
        raise CommandRefused(
            f'{hold_name(hold)} takes no answer; take {hold.item} off the belt and say so with '
            f'remove-item {hold.item}'
        )
    if command.answer not in hold.answers:
        raise CommandRefused(
            f'{hold_name(hold)} can be answered with '
            f'{offer_words(hold.answers, command.by.role)}; found {command.answer!r}'
        )
    if command.results and (command.answer != MARK_DONE or hold.item is None):
        raise CommandRefused(
            f'results are given with {MARK_DONE}, of the task of an item; found {command.answer} '
            f'of {hold.key}'
        )
    _check_serial(state, hold, command)
    return hold


def _check_serial(state: CellState, hold: Hold, command: AnswerHold) -> None:
    """Refuse a serial that is no name; one in the history is a person's word (semantics 6.8)."""
    task = state.task(hold.key) if hold.key is not None else None
    problem = too_long(serial_in(task, command.results)) if task is not None else ''
    if problem:
        raise CommandRefused(problem)


def _retry(state: CellState, key: e.TaskKey, _: AnswerHold, now: float) -> Iterator[e.Event]:
    attempt = state.tasks[key].attempt + 1
    yield e.TaskRetrying(**key._asdict(), attempt=attempt, not_before=now)


def _again(state: CellState, key: e.TaskKey, _: AnswerHold, __: float) -> Iterator[e.Event]:
    yield begin_round(state, key)


def _mark_done(
    state: CellState, key: e.TaskKey, command: AnswerHold, _: float
) -> Iterator[e.Event]:
    yield from _without_verdict(state, key, command)
    yield e.TaskMarkedDone(**key._asdict(), results=command.results)
    yield from effects.of_success(state, key)


def _skip(state: CellState, key: e.TaskKey, command: AnswerHold, _: float) -> Iterator[e.Event]:
    yield from _without_verdict(state, key, command)
    yield e.TaskSkipped(**key._asdict(), reason=command.by.deciding(command.answer))
    yield from effects.of_passing(state, key)


def _without_verdict(
    state: CellState, key: e.TaskKey, command: AnswerHold
) -> Iterator[e.ItemNonconforming]:
    """Mark an item that passes a task although its verdict does not say so (semantics 2.8)."""
    task = state.task(key)
    if task is None or task.fails_unless is None or key.job is None or key.item is None:
        return
    if state.items[key.item].present:
        reason = command.by.deciding(command.answer)
        yield e.ItemNonconforming(job=key.job, item=key.item, task=key.task, reason=reason)


def _reject(state: CellState, key: e.TaskKey, command: AnswerHold, _: float) -> Iterator[e.Event]:
    yield from pass_over(state, key, OnFailure.REJECT, command.by.deciding(command.answer))


def _abort_job(
    state: CellState, key: e.TaskKey, command: AnswerHold, _: float
) -> Iterator[e.Event]:
    yield from pass_over(state, key, OnFailure.ABORT_JOB, command.by.deciding(command.answer))


_ANSWERS = {
    RETRY: _retry,
    AGAIN: _again,
    MARK_DONE: _mark_done,
    SKIP: _skip,
    REJECT: _reject,
    ABORT_JOB: _abort_job,
}
