"""Whatever is in the table of requests becomes a command, and all else one sentence."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from fakes.line import TYPES, Line
from fakes.operator import engineer

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.engine.asking.commands import PREPARES, asked_by_name, prepared
from bt_orchestrator.engine.runtime.deciding import DECIDERS, decided
from bt_orchestrator.model.by import Role
from bt_orchestrator.model.judging.belt_statement import AsShown, Slots
from bt_orchestrator.model.requests import (
    REQUESTS,
    TABLE,
    About,
    Asked,
    BadArguments,
    Kind,
    Parameter,
    ask,
)

ANN = engineer('Ann', 'test', 'because')
STATE = Line().begin().state

OF_KIND: dict[Kind, object] = {Kind.TEXT: 'it', Kind.WHOLE: 2, Kind.TEXTS: ['it']}
OF_ORDERS = ('queue.add', 'job.update')


def asked(name: str, **given: Any) -> Asked:
    return prepared(ask(name, ANN, **given), STATE, TYPES)


def value(parameter: Parameter) -> object:
    if parameter.name == 'component':
        return 'a2'
    if parameter.name == 'script':
        return '0123456789ab'
    if parameter.name == 'task':
        return 'TASK_A'
    return parameter.choices[0] if parameter.choices else OF_KIND[parameter.kind]


@pytest.mark.parametrize('request_', TABLE, ids=lambda request: request.name)
def test_request_is_recorded_by_word_and_subject(request_: Any) -> None:
    if request_.name in OF_ORDERS:
        return  # they are read first
    given = {p.name: value(p) for p in request_.parameters if p.is_required}
    if request_.name in ('cell.clear', 'cell.production'):
        given = {'as_shown': 7}
    made = asked(request_.name, **given)
    (record,) = decided(request_.word, made.by, **made.about)
    assert vars(record)['answer'] == request_.word
    assert vars(record)['who'] == 'Ann'
    if request_.subject:
        named = 'digest' if request_.about is About.SCRIPT else request_.subject.name
        assert vars(record)[named] == given[request_.subject.name]


def test_each_request_has_one_decider() -> None:
    assert set(DECIDERS) == set(REQUESTS)
    assert set(PREPARES) <= set(DECIDERS)


def test_what_a_request_says_is_prepared() -> None:
    assert asked('cell.clear', as_shown=7)['belt'] == AsShown(7)
    belt = Slots({1: 'J/1', 2: 'empty'})
    assert asked('cell.clear', belt=['1=J/1', '2=empty'])['belt'] == belt
    assert asked('job.move', job='J', position=2) == ask('job.move', ANN, job='J', position=2)


def test_sender_without_permission_learns_nothing_about_cell() -> None:
    view = replace(ANN, role=Role.VIEW)
    unknown = ask('component.out_of_service', view, component='amr')
    assert prepared(unknown, STATE, TYPES) is unknown


@pytest.mark.parametrize('given', [{}, {'belt': ['1=empty'], 'as_shown': 7}])
def test_clear_needs_exactly_one_belt_description(given: dict[str, Any]) -> None:
    with pytest.raises(CommandRefused, match='either every slot, as in 1=WO-1/3 and 2=empty, or'):
        asked('cell.clear', **given)


def test_unknown_request_is_refused_with_similar_names() -> None:
    for name, given, error, reason in (
        (
            'cell.fly',
            {},
            BadArguments,
            r"no request 'cell.fly'; one of cell.reset, .*, cell.clear,",
        ),
        ('cell.stop_after_lunch', {}, BadArguments, 'cell.stop_after_item, cell.stop_after_job'),
        ('job.fly', {'job': 'J'}, BadArguments, r"'job.fly'; one of job.move, .*, job.clear$"),
        ('job.' + 'x' * 5_000_000, {'job': 'J'}, BadArguments, r'job.x{0,40} … \(5000004 charac'),
        (
            'fly',
            {},
            BadArguments,
            "no request 'fly'; one of cell.reset, .*, stop.classify$",
        ),
        ('hold.fly', {'hold': '9'}, CommandRefused, 'there is no hold 9; holds now: none'),
    ):
        with pytest.raises(error, match=reason):
            asked_by_name(name, ANN, given, STATE)


def test_unoffered_hold_answer_is_refused_with_offers() -> None:
    state = Line(faults={'a2': '=abort'}).run().state
    with pytest.raises(CommandRefused, match=r"can be answered with retry, .*; found 'fly'"):
        asked_by_name('hold.fly', ANN, {'hold': '1'}, state)
    run = Line().begin()
    assert run.pause().accepted
    with pytest.raises(CommandRefused, match=r'takes no answer; .*resume'):
        asked_by_name('hold.resume', ANN, {'hold': '1'}, run.state)


def test_request_alias_names_same_request() -> None:
    assert asked_by_name('job.remove', ANN, {'job': 'J'}, STATE) == ask('job.cancel', ANN, job='J')


def test_results_are_for_mark_done_alone() -> None:
    with pytest.raises(BadArguments, match=r'hold\.skip takes hold, code; found results'):
        asked_by_name('hold.skip', ANN, {'hold': '1', 'results': '{x: 1}'}, STATE)


def test_results_are_for_a_task_that_is_held() -> None:
    with pytest.raises(CommandRefused, match='hold 9 is about no task that can have results'):
        asked('hold.mark_done', hold='9', results={'measurement': 3.5})


@pytest.mark.parametrize('results', [{'measurement': 3.5}, '{measurement: 3.5}'])
def test_results_have_the_types_of_their_task(results: object) -> None:
    state = Line(faults={'a2': '=abort'}).run().state
    (hold,) = state.holds

    def read(results: object) -> Asked:
        given = {'hold': hold, 'results': results}
        return prepared(asked_by_name('hold.mark_done', ANN, given, state), state, TYPES)

    assert read(results)['results'] == {'measurement': 3.5}
    for wrong in ({'measurement': 'much'}, '{measurement: much}'):
        with pytest.raises(CommandRefused, match=r'results: .*number.*text `much`'):
            read(wrong)


def test_unknown_component_is_refused_with_nearest_name() -> None:
    with pytest.raises(CommandRefused, match=r"there is no component 'amr'; did you mean `arm`\?"):
        asked('component.out_of_service', component='amr')
