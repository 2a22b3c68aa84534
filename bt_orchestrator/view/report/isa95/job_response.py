"""The response to a job: ISA95JobResponseDataType, and its JSON with the names of B2MML."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from enum import IntEnum

from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.jobs.isa95 import OVER, JobWord
from bt_orchestrator.model.jobs.job_record import ABORTED, QUEUED, REMOVED, RUNNING, JobRecord
from bt_orchestrator.model.status import JobStatus, ListedJob
from bt_orchestrator.view.report.csv_export import iso_time
from bt_orchestrator.view.report.isa95.codes import State, states_of
from bt_orchestrator.view.report.isa95.job_order import DESCRIPTION, RECIPE_VERSION
from bt_orchestrator.view.report.isa95.machinery import IN_RESPONSE, REASON, named_parameters
from bt_orchestrator.view.report.isa95.parts import Parameter, Text, texts_from_plain


class JobResult(IntEnum):
    """JobResult of OPC 40001-3."""

    UNKNOWN = 0
    """It has not ended."""
    SUCCESSFUL = 1
    """It ended, and every ordered item was begun."""
    UNSUCCESSFUL = 2
    """It was stopped or aborted before."""


ENDING = 'Ending'
"""A parameter of our own: stopping or aborting, from the request until the line has drained."""

RECIPE = 'RecipeID'

REST_OF = 'RestOf'

PACKED_QUANTITY = 'PackedQuantity'

COUNTS: Mapping[str, str] = {
    'RunsStarted': 'started',
    'RunsCompleted': 'left',
    'ProducedQuantity': 'produced',
    PACKED_QUANTITY: 'packed',
    'GoodQuantity': 'good',
    'ScrapQuantity': 'rejected',
    'NonconformingQuantity': 'nonconforming',
    'MissingQuantity': 'missing',
}
"""Parameters that count the items of a job, by their name in its status."""

EXTRAS: Mapping[str, str] = {
    PACKED_QUANTITY: 'items that were packed, good or nonconforming',
    'ScrapQuantity': 'items that left the line rejected',
    'NonconformingQuantity': 'packed items that passed a failed task',
    'MissingQuantity': 'items that were never placed, or taken off the belt by hand',
    RECIPE: 'recipe that the script was generated from; not there: none',
    RECIPE_VERSION: 'version of the recipe; not there: none, or not known',
    REST_OF: 'job whose items it makes that this had not begun; not there: none',
    ENDING: 'stopping or aborting: it ends when its last item has left the line',
}
"""Parameters that no standard names, and what they mean."""


@dataclass(frozen=True)
class JobResponse:
    """ISA95JobResponseDataType; what is empty is not known, or not there."""

    id: str
    order: str
    """JobOrderID."""
    states: tuple[State, ...]
    """JobState: the state, and behind it its substate."""
    description: Text | None = None
    start: float | None = None
    """When the job left the queue, seconds since the epoch."""
    end: float | None = None
    """When its last item had left."""
    data: tuple[Parameter, ...] = ()
    lots: tuple[tuple[str, str, int], ...] = ()
    """MaterialActual: name and lot of what went into its items, and into how many."""


def has_response(status: JobStatus) -> bool:
    """Tell whether a job belongs into JobOrderResponseList: it has started."""
    return status.started_at is not None or status.state in OVER


def response_of(job: ListedJob, interrupted: str = '') -> JobResponse:
    """Return the response about a listed job.

    :param interrupted: why the line stands still, in words; empty: it does not
    """
    status = job.status
    reason = interrupted if status.state.substate and not job.reason else job.reason
    return _response(status, job.details, reason)


def response_of_record(record: JobRecord) -> JobResponse | None:
    """Return the response about a job of a journal; None: it has not started."""
    if record.status in (QUEUED, REMOVED):
        return None
    counts = record.counts
    word = {RUNNING: JobWord.RUNNING, ABORTED: JobWord.ABORTED}.get(record.status, JobWord.ENDED)
    status = JobStatus(
        record.job,
        record.script,
        word,
        recipe=record.recipe,
        recipe_version=record.recipe_version,
        rest_of=record.rest_of,
        quantity=record.quantity,
        queued_at=record.queued,
        started_at=record.started,
        ended_at=record.ended,
        first_piece=record.first_piece,
        first_piece_state=record.first_piece_state,
        good=counts.good,
        **vars(counts),
    )
    response = _response(status, record.terms.details, record.reason)
    used = Counter(lot for item in record.items.values() for lot in item.lots.items())
    return replace(response, lots=tuple((*lot, number) for lot, number in used.items()))


def _response(status: JobStatus, details: Mapping[str, object], reason: str) -> JobResponse:
    return JobResponse(
        status.id,
        status.id,
        states_of(status.state, awaits_start=status.awaits_start),
        next(iter(texts_from_plain(details.get(DESCRIPTION))), None),
        status.started_at,
        status.ended_at,
        (*named_parameters(details, IN_RESPONSE), *_data(status, reason)),
    )


def _data(status: JobStatus, reason: str) -> Iterator[Parameter]:
    for name, count in COUNTS.items():
        yield Parameter(name, getattr(status, count))
    yield Parameter('JobResult', int(_result(status)))
    if status.recipe:
        yield Parameter(RECIPE, status.recipe)
    if status.recipe_version is not None:
        yield Parameter(RECIPE_VERSION, status.recipe_version)
    if status.rest_of:
        yield Parameter(REST_OF, status.rest_of)
    if status.expected_end_s is not None:
        yield Parameter('EstimatedRemainingTime', _rounded_ms(status.expected_end_s))
    if status.first_piece:
        yield Parameter('FirstPiece', status.first_piece)
        yield Parameter('FirstPieceState', status.first_piece_state)
    if reason:
        yield Parameter(REASON, Text(reason))
    if status.ending:
        yield Parameter(ENDING, status.ending)


def _rounded_ms(seconds: float) -> float:
    """Return whole steps of ten seconds: a response does not change with every status."""
    return math.ceil(seconds / 10) * 10_000.0


def _result(status: JobStatus) -> JobResult:
    if status.state not in OVER:
        return JobResult.UNKNOWN
    is_whole = status.state is JobWord.ENDED and status.started >= status.quantity
    return JobResult.SUCCESSFUL if is_whole else JobResult.UNSUCCESSFUL


# --- as JSON ------------------------------------------------------------------------------------


def b2mml(response: JobResponse) -> dict[str, object]:
    """Return a response as JSON with the names of B2MML; times are ISO 8601 in UTC."""
    plain: dict[str, object] = {'ID': response.id}
    if response.description is not None:
        plain['Description'] = [response.description.text]
    plain['JobOrderID'] = response.order
    for name, moment in (('StartTime', response.start), ('EndTime', response.end)):
        if moment is not None:
            plain[name] = iso_time(moment)
    plain['JobState'] = '/'.join(state.text for state in response.states)
    if response.lots:
        plain['MaterialActual'] = [_material(*lot) for lot in response.lots]
    plain['JobResponseData'] = [
        {'ID': entry.id, 'Value': list(_b2mml_values(entry.value))} for entry in response.data
    ]
    return {'JobResponse': plain}


def _material(name: str, lot: str, items: int) -> dict[str, object]:
    return {
        'MaterialDefinitionID': [name],
        'MaterialLotID': [lot],
        'MaterialUse': 'Consumed',
        'MaterialActualProperty': [
            {'ID': 'Items', 'Value': list(_b2mml_values(items))},
        ],
    }


def _b2mml_values(value: object) -> Iterator[dict[str, str]]:
    for member in value if isinstance(value, tuple) else (value,):
        known = member.text if isinstance(member, Text) else member
        text = known if isinstance(known, str) else json_of(known)
        yield {'ValueString': text, 'DataType': _DATA_TYPES.get(type(known), 'string')}


_DATA_TYPES: Mapping[type, str] = {bool: 'boolean', int: 'integer', float: 'double', str: 'string'}
