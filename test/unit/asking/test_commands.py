"""Whatever is in the table of requests becomes a command, and all else one sentence."""

from __future__ import annotations

from typing import Any

import pytest
from fakes.line import TYPES, Line
from fakes.operator import engineer

from bt_orchestrator.asking.commands import command, command_of
from bt_orchestrator.errors import CommandRefused
from bt_orchestrator.model import cell_commands as c
from bt_orchestrator.model.belt_statement import AsShown, Slots
from bt_orchestrator.model.commands import AnswerHold, RemoveItem
from bt_orchestrator.model.jobs.job_commands import ControlJob, MoveJob, RunNext, StopAfter
from bt_orchestrator.model.requests import TABLE, About, Kind, Parameter, ask
from bt_orchestrator.runtime.command_record import decided

ANN = engineer('Ann', 'test', 'because')
STATE = Line().begin().state

OF_KIND: dict[Kind, object] = {Kind.TEXT: 'it', Kind.WHOLE: 2}
OF_ORDERS = ('queue.add', 'job.update')


def asked(name: str, **given: Any) -> object:
    return command_of(ask(name, ANN, **given), STATE, TYPES)


def value(parameter: Parameter) -> object:
    if parameter.name == 'component':
        return 'a2'
    if parameter.name == 'script':
        return '0123456789ab'
    return parameter.choices[0] if parameter.choices else OF_KIND[parameter.kind]


@pytest.mark.parametrize('request_', TABLE, ids=lambda request: request.name)
def test_a_request_is_recorded_by_its_word(request_: Any) -> None:
    if request_.name in OF_ORDERS:
        return  # they are read first
    given = {p.name: value(p) for p in request_.parameters if p.is_required}
    if request_.name == 'cell.clear':
        given = {'as_shown': 7}
    (record,) = decided(command_of(ask(request_.name, ANN, **given), STATE, TYPES))  # type: ignore[arg-type]
    assert vars(record)['answer'] == request_.word
    assert vars(record)['who'] == 'Ann'


def test_what_a_request_says_is_in_its_command() -> None:
    assert asked('cell.resume', hold='3') == c.Resume(ANN, hold='3')
    assert asked('cell.resume', everyones=True) == c.Resume(ANN, everyones=True)
    assert asked('cell.clear', as_shown=7) == c.Clear(ANN, belt=AsShown(7))
    belt = Slots({1: 'J/1', 2: 'empty'})
    assert asked('cell.clear', belt=['1=J/1', '2=empty']) == c.Clear(ANN, belt=belt)
    assert asked('cell.stop_after_job') == StopAfter('job', ANN)
    assert asked('job.move', job='J', position=2) == MoveJob('J', 2, ANN)
    assert asked('job.next', job='J') == RunNext('J', ANN)
    assert asked('job.cancel', job='J') == ControlJob('cancel', 'J', ANN)
    assert asked('item.remove_item', item='J/1') == RemoveItem('J/1', ANN)
    assert asked('hold.skip', hold='1') == AnswerHold('1', 'skip', ANN)


@pytest.mark.parametrize('given', [{}, {'belt': ['1=empty'], 'as_shown': 7}])
def test_clear_says_what_is_on_the_belt_in_one_way(given: dict[str, Any]) -> None:
    with pytest.raises(CommandRefused, match='either every slot, as in 1=WO-1/3 and 2=empty, or'):
        asked('cell.clear', **given)


OF_JOBS = 'next, release, hold, pause, resume, stop, requeue, abort, cancel, remove, clear'


def test_words_that_nobody_knows() -> None:
    all_words = (
        "unknown command 'fly'; one of reset, start, pause, resume, stop, abort, clear, "
        'out_of_service, in_service, release_script$'
    )
    with pytest.raises(CommandRefused, match=all_words):
        command(About.CELL, 'fly', ANN, {}, STATE, TYPES)
    run = Line().begin()
    for about, word, given, said in (
        (About.JOB, 'fly', {'job': 'J'}, f"unknown command 'fly'; one of {OF_JOBS}"),
        (About.CELL, 'stop_after_lunch', {}, "one of item, job, never; found 'lunch'"),
        (About.HOLD, 'fly', {'hold': '9'}, 'there is no hold 9; holds now: none'),
    ):
        asked_ = command(about, word, ANN, given, run.state, TYPES)
        answer = run.ask(asked_)
        assert not answer.accepted
        assert said in answer.message


def test_a_move_needs_a_position() -> None:
    """It is missing where the word comes without arguments, as in `~/queue/command`."""
    with pytest.raises(CommandRefused, match='to move J, name its new position, from 1'):
        command(About.JOB, 'move', ANN, {'job': 'J'}, STATE, TYPES)


def test_results_are_for_a_task_that_is_held() -> None:
    with pytest.raises(CommandRefused, match='hold 9 is about no task that can have results'):
        asked('hold.mark_done', hold='9', results={'measurement': 3.5})


@pytest.mark.parametrize('results', [{'measurement': 3.5}, '{measurement: 3.5}'])
def test_results_have_the_types_of_their_task(results: object) -> None:
    state = Line(faults={'a2': '=abort'}).run().state
    (hold,) = state.holds

    def read(results: object) -> object:
        return command(
            About.HOLD, 'mark_done', ANN, {'hold': hold, 'results': results}, state, TYPES
        )

    assert read(results) == AnswerHold(hold, 'mark_done', ANN, {'measurement': 3.5})
    for wrong in ({'measurement': 'much'}, '{measurement: much}'):
        with pytest.raises(CommandRefused, match=r'results: .*number.*text `much`'):
            read(wrong)


def test_a_component_that_is_not_there_is_refused_with_the_nearest_name() -> None:
    with pytest.raises(CommandRefused, match=r"there is no component 'amr'; did you mean `arm`\?"):
        asked('component.out_of_service', component='amr')
