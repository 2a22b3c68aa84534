"""Commands in plain texts, and the requests that they stand for."""

from __future__ import annotations

import pytest

from bt_orchestrator.extensions.opcua.mes.plain_commands import (
    Unclear,
    answer_of,
    command_of,
    order_of,
    verbs,
    with_code,
)
from bt_orchestrator.model.by import Role
from bt_orchestrator.model.jobs.order import RecipeChoice, WorkOrder
from bt_orchestrator.model.requests import REQUESTS, About
from bt_orchestrator.model.state import Hold


def hold(id_: str, *answers: str, item: str | None = None) -> Hold:
    return Hold(id_, 'WO-1', 3, item, None, 'failed', 'it failed', answers, 0.0)


def test_an_order_has_its_parameters_as_texts() -> None:
    order = order_of('WO-1', 'mix', 3, ['speed=12', ' lot = a=b ', 'note='])
    assert order == WorkOrder('mix', 'WO-1', 3, {'speed': '12', 'lot': 'a=b', 'note': ''})


def test_zero_quantity_defers_to_script() -> None:
    assert order_of('WO-1', 'mix', 0, []).quantity is None


def test_an_order_may_name_a_recipe() -> None:
    made = order_of('WO-1', 'P-1', 2, ['lot=7'], ['P-1'])
    assert (made.script, made.recipe) == ('', RecipeChoice(('P-1',)))
    assert order_of('WO-1', 'mix', 2, [], ['P-1']).script == 'mix'


def test_every_mistake_of_an_order_is_told() -> None:
    with pytest.raises(Unclear) as error:
        order_of('', '', 1, ['lot', '=1', 'a=1', 'a=2'])
    assert error.value.findings == (
        "Id: '' cannot be one: it is empty",
        'Script: it is empty; name a script, or a recipe',
        "Parameters: expected name=value, found 'lot'",
        "Parameters: expected name=value, found '=1'",
        'Parameters: a is given twice',
    )


@pytest.mark.parametrize(
    ('verb', 'job', 'name'),
    [
        ('abort', '', 'cell.abort'),
        (' Stop ', '', 'cell.stop'),
        ('stop', 'WO-1', 'job.stop'),
        ('hold', 'WO-1', 'job.hold'),
        ('next', 'WO-1', 'job.next'),
    ],
)
def test_verb_addresses_cell_or_job(verb: str, job: str, name: str) -> None:
    command = command_of(verb, job)
    assert command.request is REQUESTS[name]
    assert command.arguments == ({'job': job} if job else {})


@pytest.mark.parametrize(('verb', 'job'), [('cancel', ''), ('reset', 'WO-1'), ('move', 'WO-1')])
def test_wrong_or_incomplete_verb_is_rejected(verb: str, job: str) -> None:
    with pytest.raises(Unclear, match=rf"^Verb: expected a command to .*; found '{verb}'$"):
        command_of(verb, job)


def test_verbs_with_extra_arguments_are_not_offered() -> None:
    offered = {verb.name for about in (About.CELL, About.JOB) for verb in verbs(about)}
    assert {'cell.reset', 'cell.stop_after_item', 'job.cancel'} <= offered
    assert 'job.move' not in offered


def test_an_answer_is_one_that_is_possible_now() -> None:
    holds = [hold('3', 'retry', 'skip'), hold('4', 'remove_item', item='WO-1/2')]
    retried = answer_of('3', 'Retry', holds)
    assert (retried.request.name, retried.arguments) == ('hold.retry', {'hold': '3'})
    removed = answer_of('4', 'remove_item', holds)
    assert (removed.request.name, removed.arguments) == ('item.remove_item', {'item': 'WO-1/2'})
    with pytest.raises(Unclear, match=r'possible now \(retry, skip\); found .reject.'):
        answer_of('3', 'reject', holds)
    with pytest.raises(Unclear, match=r'one that waits \(3, 4\); found .5.'):
        answer_of('5', 'retry', holds)


def test_7_1_rejected_answer_lists_answers_per_role() -> None:
    holds = [hold('3', 'retry', 'abort_job')]
    expected = r'possible now \(retry; an engineer may also: abort_job\); found'
    with pytest.raises(Unclear, match=expected):
        answer_of('3', 'skip', holds, Role.OPERATE)


def test_every_hold_takes_remarks() -> None:
    answer = answer_of('7', 'acknowledge', [hold('7', 'resume')])
    assert (answer.request.name, answer.arguments) == ('hold.acknowledge', {'hold': '7'})


def test_a_pause_is_released_by_its_id() -> None:
    answer = answer_of('7', 'resume', [hold('7', 'resume')])
    assert (answer.request.name, answer.arguments) == ('cell.resume', {'hold': '7'})


def test_code_goes_only_with_supporting_requests() -> None:
    pause = command_of('pause', '')
    assert with_code(pause, 'LUNCH').arguments == {'code': 'LUNCH'}
    assert with_code(pause, '') == pause
    with pytest.raises(Unclear, match='for release has no reason of the plant'):
        with_code(command_of('release', 'WO-1'), 'LUNCH')
