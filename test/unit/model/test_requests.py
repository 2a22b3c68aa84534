"""The table of requests says who may ask what, and what is possible where."""

from __future__ import annotations

from dataclasses import replace

import pytest
from fakes.operator import engineer

from bt_orchestrator.model.by import Role
from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.model.jobs.job_control import JobFacts
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.requests import (
    REQUESTS,
    TABLE,
    BadArguments,
    Why,
    ask,
    of_cell,
    of_hold,
    of_job,
)

ANN = engineer('Ann', 'test', 'because')


def words(role: Role) -> set[str]:
    return {request.name for request in TABLE if role in request.roles}


def test_names_are_unique() -> None:
    assert len(REQUESTS) == len(TABLE)


def test_who_may_ask_what() -> None:
    assert words(Role.VIEW) == set()
    assert words(Role.ENGINEER) == set(REQUESTS)
    queue = {'queue.add'} | {f'job.{word}' for word in ('hold', 'release', 'pause', 'resume')}
    queue |= {'job.stop', 'job.requeue', 'job.clear'}
    assert words(Role.MES) == queue | {'job.update', 'job.cancel'}
    answers = {
        f'hold.{word}' for word in ('retry', 'again', 'change', 'mark_done', 'skip', 'reject')
    }
    remarks = {'hold.acknowledge', 'hold.comment'}
    cell = {f'cell.{word}' for word in ('reset', 'start', 'pause', 'resume', 'stop', 'abort')}
    cell |= {'cell.local', 'cell.remote'}
    after = {f'cell.stop_after_{word}' for word in ('item', 'job', 'never')}
    places = {'job.move', 'job.next', 'queue.arrange'}
    places |= {'job.another'}
    service = {'component.out_of_service', 'component.in_service', 'component.cancel_task'}
    of_operators = queue | answers | remarks | cell | after | places | service
    assert words(Role.OPERATE) == of_operators | {'stop.classify'}


@pytest.mark.parametrize('recipes', [[None], ['a', 1], [['a']], [{}]])
def test_texts_are_texts(recipes: list[object]) -> None:
    with pytest.raises(BadArguments, match=r'recipe of job\.update is texts'):
        ask('job.update', ANN, job='J', recipe=recipes)


def test_danger_does_not_wait_for_a_reason() -> None:
    at_once = {request.name for request in TABLE if request.why is Why.AFTERWARDS}
    assert at_once == {'cell.abort', 'cell.pause', 'cell.stop', 'component.cancel_task'}
    twice = {request.name for request in TABLE if request.is_confirmed}
    assert twice == {
        'cell.clear',
        'cell.production',
        'hold.reject',
        'hold.abort_job',
        'item.remove_item',
        'job.cancel',
        'job.abort',
    }


def test_what_is_possible_where() -> None:
    assert [r.word for r in of_cell(PackmlState.ABORTED)][:3] == ['pause', 'resume', 'clear']
    queued = [r.word for r in of_job(JobFacts(JobWord.ALLOWED_TO_START))]
    assert queued == ['move', 'next', 'hold', 'update', 'abort', 'cancel']
    assert [r.word for r in of_job(JobFacts(JobWord.RUNNING, 'stopping'))] == ['abort']
    assert [r.word for r in of_job(JobFacts(JobWord.ENDED))] == ['clear']
    assert [r.word for r in of_job(JobFacts(JobWord.RUNNING))] == [
        'pause',
        'stop',
        'requeue',
        'abort',
    ]
    running = JobFacts(JobWord.RUNNING)
    for no_rest in (replace(running, is_by_recipe=False), replace(running, left=0)):
        assert [r.word for r in of_job(no_rest)] == ['pause', 'stop', 'abort']
    assert [r.name for r in of_hold(('retry', 'remove_item', 'resume'))] == [
        'hold.retry',
        'item.remove_item',
        'cell.resume',
    ]


def test_arguments_are_checked() -> None:
    asked = ask('hold.mark_done', ANN, hold='3', results={'x': 1.5})
    assert asked.arguments == {'hold': '3', 'results': {'x': 1.5}}
    assert ask('cell.resume', ANN, hold=None).arguments == {}
    for name, arguments, message in (
        ('hold.retry', {}, 'hold.retry needs hold: id of the hold'),
        ('job.move', {'job': 'A', 'position': True}, 'position of job.move is whole number'),
        ('job.hold', {'job': 'A', 'place': 1}, 'job.hold takes job; found place'),
        ('cell.reset', {'x': 1}, 'cell.reset takes nothing; found x'),
        ('cell.fly', {}, "there is no request 'cell.fly'; one of cell.reset"),
    ):
        with pytest.raises(BadArguments, match=message):
            ask(name, ANN, **arguments)
