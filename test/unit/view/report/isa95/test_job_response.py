"""Job responses, and their JSON with the names of B2MML."""

from __future__ import annotations

from dataclasses import replace

import pytest

from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.model.jobs.job_record import Counts, JobRecord
from bt_orchestrator.model.jobs.order import Terms
from bt_orchestrator.model.status import JobStatus, ListedJob
from bt_orchestrator.view.report.isa95.job_response import (
    JobResult,
    b2mml,
    has_response,
    response_of,
    response_of_record,
)
from bt_orchestrator.view.report.isa95.parts import Parameter, Text

ENDED = ListedJob(
    JobStatus(
        'WO-7',
        'filling',
        JobWord.ENDED,
        quantity=4,
        started_at=10.0,
        ended_at=70.5,
        started=4,
        placed=4,
        packed=2,
        rejected=1,
        nonconforming=1,
        missing=1,
        good=1,
        by_hand=1,
    ),
    {'lot': 'A7'},
    {'Description': ['For ACME'], 'Customers': ['ACME'], 'PlannedSetupTime': 5},
)


def data(job: ListedJob, **more: str) -> dict[str, object]:
    return {parameter.id: parameter.value for parameter in response_of(job, **more).data}


def test_times_counts_and_result() -> None:
    response = response_of(ENDED)
    assert (response.start, response.end) == (10.0, 70.5)
    assert response.description == Text('For ACME')
    assert data(ENDED) == {
        'Customers': ('ACME',),
        'RunsStarted': 4,
        'RunsCompleted': 4,
        'ProducedQuantity': 4,
        'PackedQuantity': 2,
        'GoodQuantity': 1,
        'ScrapQuantity': 1,
        'NonconformingQuantity': 1,
        'MissingQuantity': 1,
        'JobResult': 1,
    }


@pytest.mark.parametrize(
    ('word', 'started', 'result'),
    [
        (JobWord.RUNNING, 2, JobResult.UNKNOWN),
        (JobWord.HELD, 4, JobResult.UNKNOWN),
        (JobWord.ENDED, 4, JobResult.SUCCESSFUL),
        (JobWord.ENDED, 3, JobResult.UNSUCCESSFUL),
        (JobWord.ABORTED, 4, JobResult.UNSUCCESSFUL),
    ],
)
def test_job_succeeds_when_all_items_began(word: JobWord, started: int, result: JobResult) -> None:
    job = replace(ENDED, status=replace(ENDED.status, state=word, started=started))
    assert data(job)['JobResult'] == result


def test_ending_is_reported_until_line_has_drained() -> None:
    status = replace(ENDED.status, state=JobWord.RUNNING, ending='stopping', expected_end_s=2.5)
    values = data(replace(ENDED, status=status, reason='no material'))
    assert values['Ending'] == 'stopping'
    assert values['ReasonForStateChange'] == Text('no material')
    assert values['EstimatedRemainingTime'] == 10_000.0


def test_an_interrupted_job_says_why_the_line_stands() -> None:
    held = replace(ENDED, status=replace(ENDED.status, state=JobWord.HELD))
    assert data(held, interrupted='pack failed')['ReasonForStateChange'] == Text('pack failed')
    assert 'ReasonForStateChange' not in data(ENDED, interrupted='pack failed')


@pytest.mark.parametrize(
    ('word', 'started_at', 'has'),
    [
        (JobWord.ALLOWED_TO_START, None, False),
        (JobWord.NOT_ALLOWED_TO_START, None, False),
        (JobWord.RUNNING, 1.0, True),
        (JobWord.ENDED, 1.0, True),
        (JobWord.ABORTED, None, True),
    ],
)
def test_job_has_response_once_started(word: JobWord, started_at: float | None, has: bool) -> None:
    assert has_response(replace(ENDED.status, state=word, started_at=started_at)) is has


def test_a_journal_tells_the_same_response() -> None:
    record = JobRecord(
        'WO-7',
        'filling',
        4,
        1.0,
        terms=Terms(details=ENDED.details),
        started=10.0,
        ended=70.5,
        status='completed',
        counts=Counts(4, 4, 2, 1, 1, 1, 1),
    )
    assert response_of_record(record) == response_of(ENDED)


def test_the_recipe_of_the_script_is_told() -> None:
    status = replace(ENDED.status, recipe='WM-100', recipe_version=3)
    values = data(replace(ENDED, status=status))
    assert (values['RecipeID'], values['RecipeVersion']) == ('WM-100', 3)
    record = JobRecord('W', 'filling', 4, 1.0, recipe='WM-100', recipe_version=3, status='running')
    response = response_of_record(record)
    assert response is not None
    assert {Parameter('RecipeID', 'WM-100'), Parameter('RecipeVersion', 3)} <= {*response.data}


@pytest.mark.parametrize('status', ['queued', 'removed'])
def test_a_job_that_has_not_started_has_none(status: str) -> None:
    assert response_of_record(JobRecord('WO-7', 'filling', 4, 1.0, status=status)) is None


def test_b2mml() -> None:
    plain = b2mml(
        replace(
            response_of(ENDED),
            data=(
                Parameter('Customers', ('ACME', 'Other')),
                Parameter('GoodQuantity', 2),
                Parameter('RunsStarted', 4),
                Parameter('Overproduction', True),
                Parameter('ReasonForStateChange', Text('late', 'en')),
            ),
        )
    )
    assert plain == {
        'JobResponse': {
            'ID': 'WO-7',
            'Description': ['For ACME'],
            'JobOrderID': 'WO-7',
            'StartTime': '1970-01-01T00:00:10.000000+00:00',
            'EndTime': '1970-01-01T00:01:10.500000+00:00',
            'JobState': 'Ended',
            'JobResponseData': [
                {
                    'ID': 'Customers',
                    'Value': [
                        {'ValueString': 'ACME', 'DataType': 'string'},
                        {'ValueString': 'Other', 'DataType': 'string'},
                    ],
                },
                {'ID': 'GoodQuantity', 'Value': [{'ValueString': '2', 'DataType': 'integer'}]},
                {'ID': 'RunsStarted', 'Value': [{'ValueString': '4', 'DataType': 'integer'}]},
                {
                    'ID': 'Overproduction',
                    'Value': [{'ValueString': 'true', 'DataType': 'boolean'}],
                },
                {
                    'ID': 'ReasonForStateChange',
                    'Value': [{'ValueString': 'late', 'DataType': 'string'}],
                },
            ],
        }
    }


def test_the_substate_is_told_behind_its_state() -> None:
    held = replace(ENDED, status=replace(ENDED.status, state=JobWord.HELD))
    response = b2mml(response_of(held))['JobResponse']
    assert isinstance(response, dict)
    assert response['JobState'] == 'Interrupted/Held'
