"""Events as records: nothing is lost, and the names users rely on stay."""

from __future__ import annotations

import json
from dataclasses import fields, replace
from typing import Any

import pytest
from fakes.action_types import FakeActionTypes
from fakes.line import THREE, Line, with_section
from fakes.shipped import ROOT

from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.codec import (
    digest,
    event_types,
    from_plain,
    from_record,
    to_plain,
    to_record,
    to_text,
)
from bt_orchestrator.model.condition import Condition
from bt_orchestrator.model.jobs.order import MadeAnew, RecipeChoice
from bt_orchestrator.model.reference import Reference, Template
from bt_orchestrator.script.cell_file import parse_cell

SCRIPT = Line().script(
    """
    quantity: 3
    params: {label: {type: str, default: none}, least: {type: float, default: 0.5}}
    lots: {glue: "${params.label}", box: "${order.id}-${params.label}"}
    initialization:
      - {id: home, task: HOME, action: /belt/do, once: true}
      - {id: ready, @a1.PREPARE}
    initialization_dependencies: [{upstream: home, downstream: ready}]
    sections:
      1: [{id: place, @a1, qty_change: 1, timeout: none, retries: 2, retry_delay: 0.5}]
      2:
        release_conveyor: after_last_conveyor_task
        tasks:
          - parallel:
            - {id: look, @a2, args: {special_argument_1: "for ${params.label}"}}
            - [{id: two, @b2, repeatable: true}, {id: three, @b2}]
          - {id: more, @b2, requires_conveyor: false, unless: "${results.look.item_present}"}
          - id: measured
            task: TASK_A
            action: /b2/do
            requires_conveyor: false
            when:
              any:
                - {value: "${results.look.measurement}", between: ["${params.least}", 2.5]}
                - {all: [{value: "${item.number}", not_equals: 0}, "${results.look.item_present}"]}
                - {value: "${params.label}", one_of: [a, b]}
      3:
        - repeat:
          - {id: glue, @b3}
          - {id: see, @b3, fails_unless: "${results.see.item_present}"}
          times: 2
        - {id: pack, @a3, qty_change: -1, runs_for: all}
    lateral_dependencies: [{flag: seen, upstream: look, downstream: pack, capacity: 2}]
    zones: {table: [two, pack]}
    """
)
REFERENCE = Template((Reference('results', 'look', ('pose', 'x')),))

SAMPLES: dict[str, Any] = {
    'seq': 7,
    'server': '010f6d0a',
    'uptime': 86400.125,
    'never_begun': True,
    'boot': '3f6d1c1e-9a3f-4a53-9d2b-6ad1a4d1e0c5',
    'time': 12.5,
    'script': 'test',
    'digest': '0123456789ab',
    'stop': '010f6d0a:12',
    'code': 'JAM',
    'cell': 'test_line',
    'definition': SCRIPT,
    'cell_definition': Line().cell,
    'job': 'WO-1',
    'quantity': 3,
    'params': {'lot': 'A7', 'depth': 2.5, 'many': True},
    'priority': -7,
    'start': 1779084000.5,
    'due': 1779090000.0,
    'details': {'$': ['text'], 'of': [{'$float': 'nan'}, None, 1.5, {'deep': []}]},
    'section': 2,
    'item': 'WO-1/3',
    'task': 'place',
    'name': 'TASK_A',
    'action': '/a2/do',
    'component': 'a2',
    'setup': 'gripper',
    'attempt': 2,
    'attempts': 3,
    'repeat': 'glue',
    'n': 2,
    'tasks': ('glue', 'see'),
    'round': 1,
    'goal': 'b04965e6-a9bb-591f-8f8a-1adcb2c8dc39',
    'args': {'pose': {'frame': 'belt', 'position': {'x': 1.5}}, 'names': ['a', 'b']},
    'cause': 'timeout',
    'stop_reason': 'own_fault',
    'owner': 'Ann',
    'origin': 'bt-orchestrator at line7',
    'role': 'operate',
    'known': 'page login',
    'claims': 'engineer (opc ua user)',
    'command': 'abort',
    'results': {'measurement': 4.0, 'item_present': False},
    'reason': 'aborted',
    'message': 'the gripper is empty',
    'not_before': 13.5,
    'policy': 'continue',
    'beat': 4,
    'flag': 'seen',
    'count': 1,
    'how': 'packed',
    'ready': True,
    'value': 'READY',
    'hold': '3',
    'control': 'local',
    'mode': 'manual',
    'key': 'ann',
    'public': 'AAAA',
    'number': 7,
    'answers': ('retry', 'skip'),
    'items': ('WO-1/3', 'WO-2/1'),
    'first_piece': True,
    'another': True,
    'answer': 'retry',
    'who': 'Ann',
    'state': 'Execute',
    'previous': 'Starting',
    'position': 2,
    'recipe': 'WM-100',
    'recipe_version': 3,
    'recipe_digest': '1c2d3e4f5a6b',
    'rest_of': 'WO-1000',
    'anew': MadeAnew(('component_4b',), ('component_3a',), 18.1, 12.5),
    'choice': RecipeChoice(('WM-100', 'WM-101'), 3, {'insert': 'component_3a'}),
    'held': True,
    'ranked': True,
    'awaits_start': True,
    'awaits_release': True,
    'cell_digest': '6a8f0c1d2e3f',
    'unavailable': ('a2',),
    'jobs': ('WO-2', 'WO-3'),
    'exit_status': 'stopped',
    'counts': {'started': 3, 'packed': 2},
    'after': 'item',
    'history': '6a8f0c1d',
    'restored': True,
    'left_out': ('image',),
    'since': 11.5,
    'commands': {'hold': 40, '...': 2},
    'missing': '2 events are missing',
    'servers': ('/one', '/two'),
    'goals': ('b04965e6-a9bb-591f-8f8a-1adcb2c8dc39',),
    'seconds': -3600.0,
    'lots': {'glue': 'L-77'},
    'serial': 'SN-4711',
    'controller_said': 'gripper open',
    'last_feedback': '{"current_sub_task": "closing"}',
    'topic_says': 'it succeeded',
}
"""A value for every field of every event."""

NAMES = (
    'job.queued job.started job.completed job.aborted task.started task.succeeded task.failed '
    'task.retrying task.skipped cycle.started cycle.completed flag.raised flag.lowered '
    'belt.index_started belt.indexed item.placed item.moved item.rejected item.removed '
    'cell.state_changed hold.raised hold.released operator.decided'
)


def sample(name: str) -> e.Event:
    """Return an event of a name, with a value in every field."""
    kind = event_types()[name]
    return kind(**{field.name: SAMPLES[field.name] for field in fields(kind)})


@pytest.mark.parametrize('name', event_types())
def test_every_event_comes_back_as_it_was(name: str) -> None:
    event = sample(name)
    record = to_record(event)
    assert record['event'] == name
    assert to_text(event) == json.dumps(record, ensure_ascii=False)
    assert from_record(json.loads(json.dumps(record))) == event


@pytest.mark.parametrize(
    'value', ['größer ☃', '"\\\n\x01\x7f', 'a\ud800ö', None, 3, 2.5, True, [1]]
)
def test_event_text_equals_text_of_its_record(value: Any) -> None:
    event = e.TaskFailed(
        **e.INDEX_KEY._asdict(), seq=1, time=2.0, attempt=value, reason=value, message=value
    )
    has_utf8 = value != 'a\ud800ö'
    assert to_text(event) == json.dumps(to_record(event), ensure_ascii=not has_utf8)


@pytest.mark.parametrize('name', event_types())
def test_every_event_survives_without_optional_fields(name: str) -> None:
    full = sample(name)
    places = ('job', 'section', 'item', 'goal', 'hold')
    absent: dict[str, Any] = {
        field.name: None
        for field in fields(full)
        if field.name in places and field.default is None
    }
    event = replace(full, **absent)
    record = to_record(event)
    assert not absent.keys() & record.keys()
    assert from_record(json.loads(json.dumps(record))) == event


def test_the_names_that_users_rely_on() -> None:
    assert set(NAMES.split()) <= set(event_types())


def test_record_begins_with_fields_used_for_search() -> None:
    event = e.ItemPlaced(seq=1, time=0.0, job='J', item='J/1', section=1)
    assert list(to_record(event)) == ['seq', 'time', 'event', 'job', 'section', 'item']


def test_a_text_with_references_keeps_them() -> None:
    task = replace(SCRIPT.tasks['look'], args={'where': REFERENCE, 'all': [{'x': REFERENCE}]})
    step = replace(SCRIPT.sections[2].steps[0], tracks=((task,),))
    sections = {2: replace(SCRIPT.sections[2], steps=(step,))}
    event = e.ScriptLoaded(
        script='test', digest='d', definition=replace(SCRIPT, sections=sections)
    )
    assert from_record(json.loads(json.dumps(to_record(event)))) == event


def test_an_unknown_event_is_an_error() -> None:
    with pytest.raises(KeyError):
        from_record({'seq': 1, 'time': 0.0, 'event': 'item.dropped'})


def test_scripts_that_say_the_same_have_one_digest() -> None:
    line = Line()
    assert digest(line.script(THREE)) == digest(line.script(THREE))
    assert digest(line.script(THREE)) != digest(line.script(with_section(2, '- {id: w, @b2}')))


def test_older_conditions_are_read_and_keep_digest() -> None:
    boolean = {'value': {'$': [{'source': 'params', 'name': 'b'}]}, 'negated': True}
    named = Template((Reference('params', 'b'),))
    assert from_plain(Condition, boolean) == Condition(named, negated=True)
    assert to_plain(Condition(named, negated=True)) == boolean
    number = {**boolean, 'equals': 3}
    assert to_plain(from_plain(Condition, number)) == number


@pytest.mark.parametrize('name', ['gear_motor_cell.yaml', 'cell_with_capabilities.yaml'])
def test_cell_with_capabilities_survives_round_trip(name: str) -> None:
    text = (ROOT / 'config' / name).read_text(encoding='utf-8')
    written = parse_cell(text, name, FakeActionTypes())
    read = from_plain(Cell, json.loads(json.dumps(to_plain(written))))
    assert read == written
    assert digest(read) == digest(written)


def test_a_digest_survives_the_journal() -> None:
    event = e.ScriptLoaded(script='test', digest='d', definition=SCRIPT)
    again = from_record(json.loads(json.dumps(to_record(event))))
    assert isinstance(again, e.ScriptLoaded)
    assert digest(again.definition) == digest(SCRIPT)


@pytest.mark.parametrize('wanted', [True, 1, 1.0])
def test_number_equal_to_true_keeps_its_type(wanted: object) -> None:
    condition = Condition(Template((Reference('item', 'number'),)), equals=wanted)
    read = from_plain(Condition, json.loads(json.dumps(to_plain(condition))))
    assert (read.words, type(read.equals)) == (condition.words, type(wanted))
