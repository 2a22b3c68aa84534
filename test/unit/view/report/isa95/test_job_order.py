"""Job orders of ISA-95 and work orders of ours."""

from __future__ import annotations

import dataclasses
import json
import math
from typing import Any

import pytest

from bt_orchestrator.extensions.opcua.mes.followed_jobs import FollowedJobs
from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import known_event, to_text
from bt_orchestrator.model.jobs.order import RecipeChoice, Terms
from bt_orchestrator.model.status import ListedJob
from bt_orchestrator.view.report.isa95.codes import ReturnStatus, Unfit
from bt_orchestrator.view.report.isa95.job_order import (
    RECIPE_VERSION,
    JobOrder,
    changes,
    job_order,
    reason_in,
    work_order,
)
from bt_orchestrator.view.report.isa95.parts import Parameter, Text, WorkMaster

MALFORMED, NOT_ACCEPTED = ReturnStatus.MALFORMED, ReturnStatus.NOT_ACCEPTED

WHOLE = JobOrder(
    'WO-7',
    (Text('For ACME', 'en'), Text('Für ACME', 'de')),
    (WorkMaster('filling', parameters=(Parameter('lot', 'A7'), Parameter('speed', 2.5))),),
    start=1_800_000_000.0,
    end=1_800_003_600.0,
    priority=7,
    parameters=(
        Parameter('RunsPlanned', 12),
        Parameter('JobName', (Text('Batch', 'en'),)),
        Parameter('Customers', ('ACME',)),
        Parameter('CustomerOrderNumbers', ('C-1', 'C-2')),
        Parameter('JobExecutionMode', 2),
        Parameter(
            'PlannedOrderQuantity', 40.0, unit='pcs', parts=(Parameter('Overproduction', True),)
        ),
    ),
    personnel=({'ID': 'night shift'},),
    equipment=({'ID': 'camera', 'EquipmentUse': 'inspection'},),
    material=({'MaterialDefinitionID': 'M-1', 'Quantity': '40'},),
)


RECIPES = ('WM-100', 'WM-200')

BY_RECIPE = dataclasses.replace(
    WHOLE,
    work_masters=(WorkMaster('WM-100', parameters=(Parameter('lot', 'A7'),)),),
    parameters=(Parameter('RunsPlanned', 12), Parameter('RecipeVersion', 3)),
    equipment=({'ID': 'arm', 'EquipmentUse': 'insert'}, {'ID': 'camera'}),
)


def listed(order: JobOrder) -> ListedJob:
    """Return the job that an order becomes, as the journal tells of it."""
    made = work_order(order, recipes=RECIPES)
    terms = {field.name: getattr(made.terms, field.name) for field in dataclasses.fields(Terms)}
    queued = e.JobQueued(
        job=made.order or '',
        script=made.script or 'generated',
        digest='d',
        choice=made.recipe,
        quantity=made.quantity or 1,
        params=made.params,
        seq=1,
        **terms,
    )
    read = known_event(json.loads(to_text(queued)))
    assert read is not None
    followed = FollowedJobs()
    followed.begin()
    followed.follow(read)
    followed_job = followed.get('WO-7')
    assert followed_job is not None
    return followed_job


def with_parameters(*parameters: Parameter) -> JobOrder:
    return dataclasses.replace(WHOLE, parameters=parameters)


def statuses(order: JobOrder, **more: Any) -> set[tuple[str, ReturnStatus]]:
    with pytest.raises(Unfit) as caught:
        work_order(order, **more)
    return {(finding.where, finding.status) for finding in caught.value.findings}


def test_job_order_fields_become_work_order_fields() -> None:
    made = work_order(WHOLE)
    assert (made.order, made.script, made.quantity) == ('WO-7', 'filling', 12)
    assert made.params == {'lot': 'A7', 'speed': 2.5}
    assert (made.terms.priority, made.terms.start, made.terms.due) == (
        7,
        1_800_000_000.0,
        1_800_003_600.0,
    )


def test_names_of_opc_40001_3_and_resources_are_details() -> None:
    details = work_order(WHOLE).terms.details
    assert details['Customers'] == ['ACME']
    assert details['CustomerOrderNumbers'] == ['C-1', 'C-2']
    assert details['JobName'] == [{'Text': 'Batch', 'Locale': 'en'}]
    assert details['PlannedOrderQuantity'] == {
        'Value': 40.0,
        'EngineeringUnits': 'pcs',
        'Subparameters': {'Overproduction': True},
    }
    assert details['EquipmentRequirements'] == [{'ID': 'camera', 'EquipmentUse': 'inspection'}]


def test_journal_alone_restores_the_job_order() -> None:
    assert job_order(listed(WHOLE)) == WHOLE


def test_other_details_survive_as_one_parameter() -> None:
    order = with_parameters(Parameter('Details', '{"mine": [1, 2]}'), Parameter('RunsPlanned', 2))
    reported = job_order(listed(order))
    assert Parameter('Details', '{"mine": [1, 2]}') in reported.parameters
    assert work_order(reported).terms.details['mine'] == [1, 2]


def test_details_with_standard_names_become_other_details() -> None:
    job = dataclasses.replace(listed(WHOLE), details={'PlannedSetupTime': 'long', 'Customers': []})
    values = {parameter.id: parameter.value for parameter in job_order(job).parameters}
    assert values['Details'] == '{"PlannedSetupTime": "long"}'
    assert 'PlannedSetupTime' not in values


def test_other_parameters_are_of_the_script() -> None:
    made = work_order(with_parameters(Parameter('colour', Text('red'))))
    assert made.params == {'lot': 'A7', 'speed': 2.5, 'colour': 'red'}
    assert made.quantity is None


@pytest.mark.parametrize('id_', ['', 'a/b', ' a', 'x' * 65, 'a\nb', 'a\u202eb', '<b>'])
def test_an_id_that_cannot_be_one_is_malformed(id_: str) -> None:
    order = dataclasses.replace(WHOLE, id=id_)
    assert statuses(order) == {('JobOrderID', MALFORMED)}


@pytest.mark.parametrize('masters', [(), (WorkMaster('a'), WorkMaster('b'))], ids=['none', 'two'])
def test_an_order_names_exactly_one_work_master(masters: tuple[WorkMaster, ...]) -> None:
    order = dataclasses.replace(WHOLE, work_masters=masters)
    assert statuses(order) == {('WorkMasterID', NOT_ACCEPTED)}


@pytest.mark.parametrize(
    ('parameter', 'where', 'status'),
    [
        (Parameter('RunsPlanned', 'many'), 'JobOrderParameters.RunsPlanned', MALFORMED),
        (Parameter('RunsPlanned', True), 'JobOrderParameters.RunsPlanned', MALFORMED),
        (Parameter('RunsPlanned', 0), 'JobOrderParameters.RunsPlanned', NOT_ACCEPTED),
        (Parameter('Customers', (1,)), 'JobOrderParameters.Customers', MALFORMED),
        (Parameter('JobExecutionMode', 1.5), 'JobOrderParameters.JobExecutionMode', MALFORMED),
        (Parameter('JobExecutionMode', 2**31), 'JobOrderParameters.JobExecutionMode', MALFORMED),
        (
            Parameter('PlannedSetupTime', math.nan),
            'JobOrderParameters.PlannedSetupTime',
            MALFORMED,
        ),
        (Parameter('lot', math.nan), 'JobOrderParameters.lot', NOT_ACCEPTED),
        (Parameter('Details', 'x'), 'JobOrderParameters.Details', MALFORMED),
        (Parameter('lot', None), 'JobOrderParameters.lot', MALFORMED),
        (Parameter('lot', (1, 2)), 'JobOrderParameters.lot', MALFORMED),
        (Parameter('lot', 'B8'), 'JobOrderParameters.lot', NOT_ACCEPTED),
        (Parameter('', 1), 'JobOrderParameters', MALFORMED),
        (
            Parameter('lot', 'A7', parts=(Parameter('a', 1),)),
            'JobOrderParameters.lot',
            NOT_ACCEPTED,
        ),
    ],
)
def test_a_parameter_that_cannot_be_taken_is_named(
    parameter: Parameter, where: str, status: ReturnStatus
) -> None:
    assert statuses(with_parameters(parameter)) == {(where, status)}


@pytest.mark.parametrize('second', [12, 13])
@pytest.mark.parametrize('name', ['RunsPlanned', 'JobExecutionMode'])
def test_what_counts_once_is_given_once(name: str, second: int) -> None:
    order = with_parameters(Parameter(name, 12), Parameter(name, second))
    assert statuses(order) == {(f'JobOrderParameters.{name}', NOT_ACCEPTED)}


def test_equipment_has_to_be_in_the_cell() -> None:
    assert work_order(WHOLE, components=['camera', 'arm']).order == 'WO-7'
    assert statuses(WHOLE, components=['arm']) == {('EquipmentRequirements', NOT_ACCEPTED)}


def test_everything_that_is_wrong_is_told_at_once() -> None:
    order = JobOrder('', parameters=(Parameter('RunsPlanned', 0),))
    with pytest.raises(Unfit) as caught:
        work_order(order)
    assert caught.value.status == MALFORMED | NOT_ACCEPTED
    assert len(caught.value.findings) == 3


# --- by recipe ----------------------------------------------------------------------------------


def test_recipe_order_binds_operations_to_equipment() -> None:
    made = work_order(BY_RECIPE, ['arm', 'camera'], RECIPES)
    assert made.script == ''
    assert made.recipe == RecipeChoice(('WM-100',), 3, {'insert': 'arm'})
    assert (made.quantity, made.params) == (12, {'lot': 'A7'})


def test_unknown_recipe_name_becomes_script_name() -> None:
    made = work_order(BY_RECIPE)
    assert (made.script, made.recipe) == ('WM-100', None)
    assert made.params == {'lot': 'A7', 'RecipeVersion': 3}


@pytest.mark.parametrize(
    ('changed', 'status'),
    [
        ({'equipment': ({'ID': 'drill'},)}, ('EquipmentRequirements', NOT_ACCEPTED)),
        (
            {
                'equipment': (
                    {'ID': 'arm', 'EquipmentUse': 'insert'},
                    {'ID': 'camera', 'EquipmentUse': 'insert'},
                )
            },
            ('EquipmentRequirements', NOT_ACCEPTED),
        ),
        (
            {'parameters': (Parameter('RecipeVersion', '3'),)},
            ('JobOrderParameters.RecipeVersion', MALFORMED),
        ),
        (
            {'parameters': (Parameter('RecipeVersion', 0),)},
            ('JobOrderParameters.RecipeVersion', NOT_ACCEPTED),
        ),
    ],
)
def test_mistakes_of_an_order_by_recipe(
    changed: dict[str, Any], status: tuple[str, ReturnStatus]
) -> None:
    order = dataclasses.replace(BY_RECIPE, **changed)
    assert statuses(order, components=['arm', 'camera'], recipes=RECIPES) == {status}


def test_order_by_recipe_is_restored_unchanged() -> None:
    assert job_order(listed(BY_RECIPE)) == BY_RECIPE


@pytest.mark.parametrize(
    ('changed', 'asked'),
    [
        ({}, {}),
        ({'work_masters': ()}, {}),
        ({'parameters': ()}, {}),
        (
            {'work_masters': (WorkMaster('WM-200'),), 'parameters': (), 'equipment': ()},
            {'recipe': ['WM-200']},
        ),
        (
            {'work_masters': (), 'equipment': ({'ID': 'camera', 'EquipmentUse': 'look'},)},
            {'version': 3, 'bind': {'look': 'camera'}},
        ),
        (
            {'parameters': (Parameter(RECIPE_VERSION, 4),), 'equipment': ()},
            {'version': 4},
        ),
        ({'work_masters': (WorkMaster('filling'),), 'parameters': ()}, {'script': 'filling'}),
    ],
)
def test_update_of_recipe_job_names_recipe(
    changed: dict[str, Any], asked: dict[str, object]
) -> None:
    order = dataclasses.replace(BY_RECIPE, **changed)
    update = changes(order, listed(BY_RECIPE), recipes=RECIPES)
    named = {key: update[key] for key in ('script', 'recipe', 'version', 'bind') if key in update}
    assert named == asked


# --- updates ------------------------------------------------------------------------------------


def test_an_update_names_only_what_it_changes() -> None:
    now = listed(WHOLE)
    order = JobOrder('WO-7', priority=9, parameters=(Parameter('Customers', ('Other',)),))
    asked = changes(order, now)
    assert asked['job'] == 'WO-7'
    assert asked['priority'] == 9
    assert set(asked) == {'job', 'priority', 'details'}
    assert asked['details'] == {**now.details, 'Customers': ['Other']}


def test_full_order_update_keeps_script() -> None:
    asked = changes(WHOLE, listed(WHOLE))
    assert 'script' not in asked
    assert asked['start'] == '2027-01-15T08:00:00+00:00'
    other = dataclasses.replace(WHOLE, work_masters=(WorkMaster('another'),))
    assert changes(other, listed(WHOLE))['script'] == 'another'


def test_empty_update_is_still_a_request() -> None:
    assert changes(JobOrder('WO-7'), None) == {'job': 'WO-7'}
    # Another script is for engineers: who may not ask for it is told all the same that it is none.
    masters = (WorkMaster('another'),)
    assert changes(JobOrder('WO-7', work_masters=masters), None) == {'job': 'WO-7'}


def test_the_reason_may_come_with_the_order() -> None:
    order = with_parameters(Parameter('ReasonForStateChange', Text('customer called', 'en')))
    assert reason_in(order) == 'customer called'
    assert reason_in(WHOLE) == ''
    assert 'ReasonForStateChange' not in work_order(order).terms.details
