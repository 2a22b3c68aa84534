"""Semantics 7.1: who may ask what, what needs a reason, and how a name is told."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from fakes.commands import (
    Abort,
    AnswerHold,
    Arrange,
    ControlJob,
    MoveJob,
    Pause,
    ReleaseScript,
    RemoveItem,
    Reset,
    RunNext,
    SetService,
    Stop,
    StopAfter,
)
from fakes.line import THREE, Line
from fakes.virtual_run import VirtualRun

from bt_orchestrator.model.by import By, Known, Role
from bt_orchestrator.model.commands import Command
from bt_orchestrator.model.jobs.job_commands import AddJobs, RequeueJob, UpdateJob
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.requests import REQUESTS, About, Why, ask

LINE = Line()
SCRIPT = LINE.script(THREE)
OTHER = LINE.script(THREE, 'another')

CELL = {'abort': Abort, 'pause': Pause, 'reset': Reset, 'stop': Stop}


def eve(role: Role, reason: str = 'a test', known: Known = Known.ROS) -> By:
    return By('Eve', 'over there', reason, role, known)


COMMANDS: dict[str, Callable[[By], Command]] = {
    **{f'cell.{verb}': kind for verb, kind in CELL.items()},
    **{
        f'cell.{word}': lambda by, word=word: ask(f'cell.{word}', by)  # type: ignore[misc]
        for word in ('local', 'remote', 'manual')
    },
    'cell.production': lambda by: ask('cell.production', by, as_shown=1),
    'cell.at_panel': lambda by: ask('cell.at_panel', by),
    'component.run_task': lambda by: ask('component.run_task', by, component='a2', task='TASK_A'),
    'component.cancel_task': lambda by: ask('component.cancel_task', by, component='a2'),
    'cell.stop_after_item': lambda by: StopAfter('item', by),
    'cell.stop_after_never': lambda by: StopAfter('never', by),
    'queue.add': lambda by: AddJobs((Job('K', SCRIPT, 1, {}),), by),
    'queue.arrange': lambda by: Arrange('J', '', by),
    'job.move': lambda by: MoveJob('J', 1, by),
    'job.next': lambda by: RunNext('J', by),
    'job.update': lambda by: UpdateJob(Job('J', SCRIPT, 7, {}), by),
    'job.requeue': lambda by: RequeueJob('J', Job('J-rest', SCRIPT, 1, {}), by),
    **{
        f'job.{verb}': lambda by, verb=verb: ControlJob(verb, 'J', by)  # type: ignore[misc]
        for verb in (
            'hold',
            'release',
            'pause',
            'resume',
            'another',
            'stop',
            'abort',
            'cancel',
            'clear',
        )
    },
    'item.remove_item': lambda by: RemoveItem('J/1', by),
    'component.out_of_service': lambda by: SetService('a3', False, by),
    'component.in_service': lambda by: SetService('a3', True, by),
    'stop.classify': lambda by: ask('stop.classify', by, stop=':1', code='JAM'),
    'script.release_script': lambda by: ReleaseScript('0123456789ab', by),
    **{
        f'hold.{word}': lambda by, word=word: AnswerHold('1', word, by)  # type: ignore[misc]
        for word in (
            'retry',
            'again',
            'change',
            'mark_done',
            'skip',
            'reject',
            'abort_job',
            'acknowledge',
            'comment',
        )
    },
}
"""A command for every request but those that are made like another one here."""


def held() -> VirtualRun:
    run = Line(faults={'a2': '#1=abort'}).run()
    assert list(run.state.holds) == ['1']
    return run


def test_every_command_is_a_request_of_the_table() -> None:
    made: dict[str, Any] = {name: make(eve(Role.VIEW)) for name, make in COMMANDS.items()}
    assert {name: cmd.request.name for name, cmd in made.items()} == {cmd: cmd for cmd in made}
    others = {'cell.start', 'cell.resume', 'cell.clear', 'cell.stop_after_job'}
    assert set(REQUESTS) - set(COMMANDS) == others


@pytest.mark.parametrize('role', Role, ids=lambda role: str(role.value))
@pytest.mark.parametrize('name', COMMANDS)
def test_7_1_a_role_asks_for_what_the_table_says(name: str, role: Role) -> None:
    run = held()
    before = len(run.records)
    answer = run.ask(COMMANDS[name](eve(role)))
    is_refused_for_its_role = f'{name} is for the role' in answer.message
    assert is_refused_for_its_role is (role not in REQUESTS[name].roles), answer.message
    if is_refused_for_its_role:
        (refused,) = run.records[before:]
        assert refused['event'] == 'operator.refused'
        assert (refused['who'], refused['role']) == ('Eve', role.value)
        assert (refused['known'], refused['message']) == ('ros unauthenticated', answer.message)
        assert refused['command'] == REQUESTS[name].word


def test_7_1_refusal_names_user_request_and_role() -> None:
    answer = held().ask(AnswerHold('1', 'abort_job', eve(Role.OPERATE)))
    assert answer.message == (
        'hold.abort_job is for the role engineer, and somebody who claims to be Eve has the role '
        'operate (ros unauthenticated); nothing was done; the parameter unauthenticated_role of '
        'the node is the role of everybody in the ROS domain who does not sign, and view where '
        'signed_commands is required'
    )


def test_7_1_whose_name_is_proven_is_called_by_it() -> None:
    run = held()
    run.ask(AnswerHold('1', 'skip', eve(Role.OPERATE, known=Known.PAGE_LOGIN)))
    assert run.all('task.skipped')[-1]['reason'] == 'Eve decided skip: a test'
    assert run.all('operator.decided')[-1]['known'] == 'page login'


def test_7_1_unverified_name_is_shown_as_claim() -> None:
    run = held()
    run.ask(Stop(eve(Role.OPERATE, 'end of shift')))
    assert str(run.state.wish) == 'somebody who claims to be Eve said stop: end of shift'
    reasons = [change.get('reason') for change in run.all('cell.state_changed')]
    assert 'somebody who claims to be Eve: end of shift' in reasons


def test_7_1_another_script_is_for_engineers() -> None:
    run = VirtualRun(LINE.cell, LINE.types)
    run.submit('L', SCRIPT, 3)
    run.add(('J', SCRIPT), held=True)
    assert run.ask(UpdateJob(Job('J', SCRIPT, 2, {}), eve(Role.MES))).accepted
    refused = run.ask(UpdateJob(Job('J', OTHER, 2, {}), eve(Role.MES)))
    assert 'job.update with script is for the role engineer' in refused.message
    assert run.ask(UpdateJob(Job('J', OTHER, 2, {}), eve(Role.ENGINEER))).accepted


@pytest.mark.parametrize('name', COMMANDS)
def test_7_1_what_needs_a_reason_is_refused_without(name: str) -> None:
    run = held()
    answer = run.ask(COMMANDS[name](eve(Role.ENGINEER, reason=' ')))
    needed = REQUESTS[name].why is Why.FIRST
    assert (f'{name} needs a reason' in answer.message) is needed
    if REQUESTS[name].why is Why.AFTERWARDS and REQUESTS[name].about is About.CELL:
        assert answer.accepted
        assert run.all('operator.decided')[-1]['reason'] == ' '
