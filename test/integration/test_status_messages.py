"""A status and a description as messages: nothing is lost or changed on the way."""

from __future__ import annotations

import json
import typing
from collections.abc import Mapping
from dataclasses import make_dataclass
from typing import Any

import pytest
from bt_orchestrator_interfaces import msg, srv
from bt_orchestrator_interfaces.msg import FlagStatus
from hypothesis import given, settings
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message

from bt_orchestrator.model.codec import from_plain, hints_of, json_of, to_plain
from bt_orchestrator.model.frozen import changed
from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.model.jobs.job_record import FailureRecord, ItemRecord
from bt_orchestrator.model.jobs.order import RecipeChoice
from bt_orchestrator.model.state import Hold
from bt_orchestrator.model.status import (
    CellDescription,
    CellStatus,
    ComponentStatus,
    FinishedCycle,
    ItemStatus,
    JobStatus,
    Leadership,
    ListedJob,
    ManualGoal,
)
from bt_orchestrator.model.stop_reason import Wish
from bt_orchestrator.model.words import Words
from bt_orchestrator.ros.clock import from_time, to_time
from bt_orchestrator.ros.types import order_messages  # noqa: F401 - maps orders
from bt_orchestrator.ros.types.mapping import MAPPED, mapped
from bt_orchestrator.ros.types.status_messages import (
    StatusWriter,
    cell_description,
    cell_status,
    description_message,
    failure_message,
    item_message,
    listed_job,
    listed_message,
)

TEXTS = st.text(st.characters(exclude_categories=['Cs'], exclude_characters='\0'), max_size=8)
NAMES = TEXTS.filter(bool)
WHOLE = st.integers(0, 2**16 - 1)
SECONDS = st.floats(0.0, 2.0**31 - 2.0).map(lambda value: from_time(to_time(value)))
LATER = SECONDS.filter(bool)
INT16 = st.integers(-(2**15), 2**15 - 1)

DRAWN = {
    str: TEXTS,
    int: WHOLE,
    float: SECONDS,
    bool: st.booleans(),
    object: TEXTS | WHOLE | st.booleans() | st.none(),
}
"""By annotation; an object is what JSON holds: a field of a goal, or of a result."""

NAMED: dict[Any, dict[str, st.SearchStrategy[Any]]] = {
    ItemStatus: {'id': NAMES},
    Wish: {'command': NAMES},
    FinishedCycle: {'job': NAMES},
    Words: {'kind': NAMES},
    Leadership: {'host': NAMES},
    ManualGoal: {'component': NAMES, 'ended': st.none() | LATER},
    JobStatus: {
        'priority': INT16,
        'good': WHOLE,
        'by_hand': WHOLE,
        'recipe_version': st.none() | st.integers(1, 2**32 - 1),
        **dict.fromkeys(('start', 'due', 'started_at', 'ended_at'), st.none() | LATER),
    },
    ComponentStatus: {'out_of_service_since': st.none() | LATER},
    Hold: {
        'job': st.none() | NAMES,
        'item': st.none() | NAMES,
        'task': st.none() | NAMES,
        'section': st.none() | st.integers(1, 2**16 - 1),
    },
}
"""Where an empty text, or 0, would mean that there is nothing."""


def facts(kind: Any) -> st.SearchStrategy[Any]:
    """Draw any value of an annotated type."""
    if kind in DRAWN:
        return DRAWN[kind]
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if origin is tuple:
        return st.lists(facts(arguments[0]), max_size=3).map(tuple)
    if origin is Mapping:
        return st.dictionaries(facts(arguments[0]), facts(arguments[1]), max_size=3)
    if type(None) in arguments:
        (inner_type,) = (argument for argument in arguments if argument is not type(None))
        return st.none() | facts(inner_type)
    if hasattr(kind, '__members__'):
        return st.sampled_from(kind)
    fields = {name: facts(hint) for name, hint in hints_of(kind).items()}
    return st.builds(kind, **{**fields, **NAMED.get(kind, {})})


def named_once(status: CellStatus) -> CellStatus:
    """Return a status in which no two sections, components, jobs or holds have one name."""
    return changed(
        status,
        sections=tuple({entry.number: entry for entry in status.sections}.values()),
        components=tuple({entry.name: entry for entry in status.components}.values()),
        jobs=tuple({entry.id: entry for entry in status.jobs}.values()),
        holds=tuple({entry.id: entry for entry in status.holds}.values()),
    )


STATUSES = facts(CellStatus).map(named_once)


def sent(message: Any) -> Any:
    """Return a message as its receiver has it."""
    return deserialize_message(serialize_message(message), type(message))


@given(STATUSES)
@settings(max_examples=200, deadline=None)
def test_a_status_comes_back_as_it_was(status: CellStatus) -> None:
    assert cell_status(sent(StatusWriter().message(status))) == status


@given(STATUSES)
@settings(max_examples=50, deadline=None)
def test_a_status_comes_back_from_json(status: CellStatus) -> None:
    assert from_plain(CellStatus, json.loads(json_of(to_plain(status, whole=True)))) == status


@given(STATUSES, STATUSES)
@settings(max_examples=50, deadline=None)
def test_reused_writer_writes_the_same_status(first: CellStatus, other: CellStatus) -> None:
    writer = StatusWriter()
    mixed = changed(other, sections=first.sections, jobs=first.jobs[:1] + other.jobs)
    for status in (first, named_once(mixed), first, other):
        assert cell_status(sent(writer.message(status))) == status


@given(STATUSES)
@settings(max_examples=50, deadline=None)
def test_moved_jobs_leave_earlier_message_unchanged(status: CellStatus) -> None:
    places = ((job, n) for n, job in enumerate(status.jobs, 1))
    moved = changed(status, jobs=tuple(changed(job, position=n) for job, n in places))
    writer = StatusWriter()
    before = writer.message(status)
    assert cell_status(sent(writer.message(moved))) == moved
    assert cell_status(sent(before)) == status


@given(facts(CellDescription))
@settings(max_examples=50, deadline=None)
def test_a_description_comes_back_as_it_was(description: CellDescription) -> None:
    assert cell_description(sent(description_message(description))) == description


@pytest.mark.parametrize('choice', [None, RecipeChoice(('A', 'B'), 2, {'insert': 'arm'})])
def test_a_listed_job_comes_back_as_it_was(choice: RecipeChoice | None) -> None:
    status = JobStatus('WO-1', 'box', JobWord.RUNNING, recipe='A', recipe_version=2)
    job = ListedJob(status, {'lot': 'A7'}, {'for': 'ACME'}, 'why', choice)
    assert listed_job(sent(listed_message(job))) == job


@given(st.floats(0.0, 2.0**31 - 2.0))
def test_a_time_keeps_its_nanoseconds(seconds: float) -> None:
    assert abs(from_time(to_time(seconds)) - seconds) <= 0.5e-9


def test_times_of_today_come_back_exactly() -> None:
    times = [1764000000.0 + 0.0771234 * n for n in range(1000)]
    assert [from_time(to_time(seconds)) for seconds in times] == times


@pytest.mark.parametrize(
    ('fields', 'message'),
    [
        ({'name': str, 'count': int, 'capacity': int, 'new': str}, 'Fact.new has no field'),
        ({'name': str, 'count': int}, 'Fact has no field for capacity'),
        ({'name': str, 'count': int, 'capacity': float}, 'uint32 holds no float'),
        ({'name': int, 'count': int, 'capacity': int}, 'string holds no int'),
    ],
)
def test_fact_and_message_must_agree(fields: dict[str, type], message: str) -> None:
    with pytest.raises(TypeError, match=message):
        mapped(make_dataclass('Fact', list(fields.items())), FlagStatus)


UNMAPPED = {
    'Event': 'its record is the JSON of the journal, by model/codec.py',
    'Identity': 'a process says where it runs; nothing else has these facts',
}
"""Messages that no fact has, and the reason."""

DOORS = {
    **dict.fromkeys(('AnswerHold', 'Command', 'QueueCommand', 'QueueMove', 'RemoveItem'), 'typed'),
    'SignedRequest': 'its request is JSON beside a signature',
    **dict.fromkeys(('MakeRequest', 'QueueAdd', 'QueueStopAfter', 'SubmitOrder'), 'typed'),
    **dict.fromkeys(('GetEvents', 'GetState', 'ListJobs', 'QueueList'), 'page of facts'),
}
"""Services that only name a request and its arguments, or what part of mapped facts is wanted."""


def test_every_message_is_mapped_or_named() -> None:
    messages = {
        name for name in vars(msg) if hasattr(getattr(msg, name), '_fields_and_field_types')
    }
    services = {name for name in vars(srv) if hasattr(getattr(srv, name), 'Request')}
    named = {kind.__name__ for kind in MAPPED}
    assert messages - UNMAPPED.keys() == named & messages
    assert services - DOORS.keys() == {'QueueUpdate'}, 'its request is mapped'
    assert srv.QueueUpdate.Request in MAPPED


def test_item_and_failure_reports_match_records() -> None:
    item = ItemRecord('J/1', 3.0, nonconforming=['weigh'], results={'weigh': {'grams': 3.5}})
    report = sent(item_message(item))
    assert (report.id, report.outcome, report.nonconforming) == ('J/1', 'on_the_line', ['weigh'])
    assert json.loads(report.results) == {'weigh': {'grams': 3.5}}
    assert sent(item_message(changed(item, how='packed'))).outcome == 'packed'
    failure = failure_message(FailureRecord(3.5, 'weigh', 2, 'timeout', round=1))
    assert (failure.stamp, failure.item) == (to_time(3.5), '')
    assert (failure.task, failure.attempt, failure.round) == ('weigh', 2, 1)
