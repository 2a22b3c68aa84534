"""States as records: whatever is in the state comes back, and goes on as if nothing had been."""

from __future__ import annotations

import json
import typing
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Any

import pytest
from fakes.drawn.lines import lines
from fakes.drawn.plan import Plan
from fakes.line import THREE, Line
from fakes.plan_operator import operate
from fakes.plan_runs import ProductBench
from fakes.profiles import examples
from fakes.virtual_run import snapshot
from hypothesis import given

from bt_orchestrator.model.codec import hints_of
from bt_orchestrator.model.fold import apply
from bt_orchestrator.model.keeping import snapshot as kept
from bt_orchestrator.model.keeping.snapshot import (
    kept_fields,
    state_from_plain,
    state_to_plain,
    state_to_text,
)
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.state import (
    CellState,
    Cycle,
    ItemState,
    JobState,
    SectionState,
    same_args,
)
from bt_orchestrator.model.state.live_jobs import LiveJobs

LINE = Line()
SCRIPT = LINE.script(THREE)


def read_back(state: CellState) -> CellState:
    return state_from_plain(state.cell, json.loads(json.dumps(state_to_plain(state))))


def sample(kind: Any, number: int) -> Any:
    """Return a value of an annotation that is no default."""
    if kind is Any:
        return {'x': [1.5, 'a'], 'y': {'z': True}}
    if kind is object:
        return {'$': ['opaque'], 'x': [None, {'$float': 'nan'}]}
    if kind is Script:
        return SCRIPT
    if kind is LiveJobs:
        queued, working = sample(JobState, 7), sample(JobState, 8)
        queued.started_at = None
        return LiveJobs([queued, working])
    if isinstance(kind, type):
        return _sample_of_class(kind, number)
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if origin in (dict, Mapping):
        return {sample(arguments[0], n): sample(arguments[1], n) for n in (7, 8)}
    if origin in (list, set, tuple):
        return origin(sample(arguments[0], n) for n in (5, 6))
    return sample(arguments[0], number)  # one kind or None


def _sample_of_class(kind: type, number: int) -> Any:
    if is_dataclass(kind):
        hints = hints_of(kind)
        return kind(**{f.name: sample(hints[f.name], number) for f in fields(kind)})
    if issubclass(kind, tuple):
        return kind(*(sample(hint, number) for hint in hints_of(kind).values()))
    if issubclass(kind, Enum):
        return list(kind)[-1]
    if kind is bool:
        return True
    return {str: f'text {number}', int: number, float: number / 4}[kind]


@examples(4, 100)
@given(lines())
def test_run_survives_read_back_after_every_event(plan: Plan) -> None:
    bench = ProductBench(plan)
    operate(bench, plan.moments)
    state, copied = CellState(bench.cell), CellState(bench.cell)
    for event in bench.run.store.read():
        apply(state, event)
        copied = read_back(copied)
        apply(copied, event)
        assert snapshot(copied) == snapshot(state), event


@pytest.mark.parametrize('name', kept_fields())
def test_every_state_field_survives_read_back(name: str) -> None:
    state = CellState(LINE.cell)
    filled = sample(hints_of(CellState)[name], 2)
    if name in ('sections', 'readings'):  # as the cell has them
        there = getattr(state, name)
        filled = dict(zip(there, [*filled.values()] * len(there), strict=False))
    setattr(state, name, filled)
    assert getattr(state, name) != getattr(CellState(LINE.cell), name)
    assert getattr(read_back(state), name) == getattr(state, name)


def test_nothing_is_in_the_state_but_its_fields() -> None:
    assert list(vars(CellState(LINE.cell))) == [field.name for field in fields(CellState)]
    derived = {field.name for field in fields(CellState)} - set(kept_fields())
    assert derived == {'cell', 'preparations'}


def test_what_stands_in_two_places_is_one_thing() -> None:
    run = LINE.begin()
    run.go(until=1.5)
    again = read_back(run.state)
    (job,) = again.jobs.values()
    (name,) = job.items
    assert job.items[name] is again.items[name]
    assert job.job.script is again.scripts[job.digest]


def test_state_text_does_not_rewrite_scripts(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    state = CellState(LINE.cell)
    state.jobs.add(sample(JobState, 3))
    script = LINE.script(THREE, name='größer')
    state.scripts['0123456789ab'] = script
    assert json.loads(state_to_text(state)) == json.loads(json.dumps(state_to_plain(state)))

    def never(_: object) -> None:
        raise AssertionError('a script is written anew')

    monkeypatch.setattr('bt_orchestrator.model.codec.json_of', never)
    assert 'größer' in state_to_text(state)


def test_an_annotation_that_cannot_be_kept_is_refused() -> None:
    with pytest.raises(TypeError, match=r'no way to keep tuple\[int, str\]'):
        kept.Writer().write(tuple[int, str], (1, 'a'))
    with pytest.raises(TypeError, match='no way to keep a bytes'):
        kept.Writer().write(dict[str, bytes], {'a': b'b'})
    with pytest.raises(TypeError, match='is not one kind or None'):
        kept.Writer().write(int | str | None, 3)


def test_missing_record_field_has_its_default() -> None:
    state = CellState(LINE.cell)
    before = sample(JobState, 3)
    state.jobs.add(before)
    plain = state_to_plain(state)
    del plain['state']['beat']
    (job,) = [entry for entry in plain['objects'] if 'aborting' in entry]
    del job['aborting']
    again = state_from_plain(LINE.cell, plain)
    assert again.beat == 1
    (read,) = again.jobs.values()
    assert read.aborting is False
    assert read.items == before.items


@pytest.mark.parametrize(
    ('mode', 'arrived', 'wish'),
    [
        ('Stopped', False, 'stop'),
        ('Idle', False, 'stop'),
        ('Aborted', False, 'abort'),
        ('Stopped', True, None),
        ('Execute', True, None),
        ('Execute', False, None),
    ],
)
def test_old_stop_state_becomes_operator_command(
    mode: str, arrived: bool, wish: str | None
) -> None:
    plain = state_to_plain(CellState(LINE.cell))
    for name in ('had_work', 'stopped_by', 'stop_after_by', 'packml'):
        del plain['state'][name]
    plain['state'] |= {'order_arrived': arrived, 'mode': mode, 'stop_after': 'job'}
    state = state_from_plain(LINE.cell, plain)
    assert state.had_work is arrived
    assert (state.stopped_by and state.stopped_by.command) == wish
    assert state.stop_after_by is not None
    assert state.stop_after_by.command == 'stop_after_job'


def test_old_done_once_entries_are_kept() -> None:
    plain = state_to_plain(CellState(LINE.cell))
    plain['state']['done_once'] = ['/belt/do HOME []', "/a2/do LOAD [('recipe', 'a b')]"]
    state = state_from_plain(LINE.cell, plain)
    assert state.done_once['/belt/do HOME'] == same_args({})
    assert state.done_once['/a2/do LOAD'] == same_args({'recipe': 'a b'})


def test_a_field_that_nobody_knows_is_refused() -> None:
    plain = state_to_plain(CellState(LINE.cell))
    plain['state']['speed'] = 3
    with pytest.raises(TypeError, match='the state has no field speed'):
        state_from_plain(LINE.cell, plain)


def test_a_cell_that_has_changed_since() -> None:
    state = CellState(Line(3).cell)
    longer = state_from_plain(Line(4).cell, state_to_plain(state))
    assert longer.sections[4] == SectionState(4)
    assert longer.readings.keys() == Line(4).cell.components.keys()
    assert list(state_from_plain(Line(2).cell, state_to_plain(state)).sections) == [1, 2]
    state.items['J/1'] = ItemState('J/1', 'J', 1)
    state.sections[3].cycle = Cycle('J', 'J/1', 1)
    with pytest.raises(KeyError, match='section 3'):
        state_from_plain(Line(2).cell, state_to_plain(state))
