"""Semantics 7.2: one recorded stop reason, and both vocabularies derived from it."""

from __future__ import annotations

import pytest
from fakes.commands import Abort, Pause, Resume, Stop
from fakes.line import THREE, Line, with_section
from fakes.virtual_run import VirtualRun
from hypothesis import given, settings
from hypothesis import strategies as st

from bt_orchestrator.engine.runtime.lifecycle import SUSPEND_AFTER_S
from bt_orchestrator.model.jobs.isa95 import job_word
from bt_orchestrator.model.stop_reason import WORDS, StopReason

RULE = """
operator  Held      Interrupted/Suspended
own_fault Held      Interrupted/Held
starved   Suspended Interrupted/Held
blocked   Suspended Interrupted/Held
emergency Aborted   Interrupted/Held
"""


def not_ready(component: str) -> VirtualRun:
    """Run until nothing goes on because a component is not ready."""
    text = with_section(2, '- {id: work, @a2}')
    return Line(topics=(component,), faults={component: '#1=not_ready'}).run(text, 3)


def standing(reason: StopReason) -> VirtualRun:
    """Run a line until it stands still for a reason."""
    if reason is StopReason.OPERATOR:
        run = Line().begin(quantity=2).go(until=3.5)
        run.command(Pause)
    elif reason is StopReason.OWN_FAULT:
        run = Line(faults={'a2': '#1=abort'}).begin(quantity=2)
    elif reason is StopReason.STARVED:
        run = not_ready('a1')
    elif reason is StopReason.BLOCKED:
        run = not_ready('a3')
    else:
        run = Line().begin(quantity=2).go(until=3.5)
        run.command(Abort)
    return run.go()


@pytest.mark.parametrize('row', RULE.strip().splitlines(), ids=lambda row: row.split()[0])
def test_7_2_both_vocabularies_follow_from_the_stop_reason(row: str) -> None:
    name, cell, job = row.split()
    run = standing(StopReason(name))
    assert run.state.stop_reason is StopReason(name)
    assert run.state.packml.value == cell
    assert job_word(run.state, run.job()).value == job
    assert run.order('cell.stop_reason_changed', 'stop_reason')[-1] == name


def test_7_2_every_reason_has_its_words() -> None:
    assert set(WORDS) == set(StopReason)


# --- which reason -----------------------------------------------------------------------------


def test_7_2_first_standing_hold_is_stop_reason() -> None:
    run = Line(faults={'a2': '#1=abort'}).begin(quantity=2).go(until=3.5)
    run.command(Pause)
    run.go()
    assert len(run.state.holds) == 2
    assert run.order('cell.stop_reason_changed', 'stop_reason') == ['operator']
    run.command(Resume)
    assert run.order('cell.stop_reason_changed', 'stop_reason') == ['operator', 'own_fault']
    assert run.state.packml.value == 'Held'
    run.answer('retry')
    assert run.state.stop_reason is None
    run.go()
    assert run.ended


def test_7_2_operator_stop_suspends_jobs() -> None:
    run = Line().begin(quantity=2).go(until=3.5)
    run.command(Stop)
    run.go()
    assert run.state.stop_reason == StopReason.OPERATOR
    assert job_word(run.state, run.job()).value == 'Interrupted/Suspended'


# --- starved and blocked ----------------------------------------------------------------------


@pytest.mark.parametrize('component', ['a1', 'a3'])
def test_7_2_the_line_suspends_by_itself_and_comes_back(component: str) -> None:
    line = Line(topics=(component,), faults={component: '#1=not_ready:20'})
    run = line.run(THREE, 3)
    assert run.ended
    states = run.states
    at = states.index('Suspending')
    assert states[at : at + 4] == ['Suspending', 'Suspended', 'Unsuspending', 'Execute']
    assert run.order('cell.stop_reason_changed', 'stop_reason') == [
        {'a1': 'starved', 'a3': 'blocked'}[component],
        '',
    ]


def test_7_2_starved_is_what_everything_else_waits_for() -> None:
    line = Line(topics=('a1',), faults={'a1': '#1=not_ready:20'}, seconds={'a2': 9.0})
    run = line.run(THREE, 2)
    suspended = run.times('cell.state_changed', state='Suspended')
    # Item 1 is placed at 1.0; it is packed at 15.0, when the belt waits for the source alone.
    worked = run.times('task.succeeded', task='work', item='J/1')[0]
    assert suspended[0] == worked + SUSPEND_AFTER_S


ROUNDED_DOWN_MS = [ms for ms in range(3001, 9000) if (ms + 1000) / 1000 < ms / 1000 + 1.0]
"""Instants behind which a second, added as a float, ends a little later than the clock says."""


@given(began_ms=st.sampled_from(ROUNDED_DOWN_MS) | st.integers(3001, 9000))
@settings(max_examples=50)
def test_7_2_line_suspends_and_recovers_at_any_moment(began_ms: int) -> None:
    faults = {'a1': '#1=not_ready:20'}
    # The first item is placed at 1.0 and comes to section 2 at 3.0.
    line = Line(topics=('a1',), faults=faults, seconds={'a2': began_ms / 1000 - 3.0})
    run = line.run(THREE, 2)
    assert run.ended
    assert run.times('cell.state_changed', state='Suspended')[0] == (began_ms + 1000) / 1000


def test_7_2_briefly_busy_component_suspends_nothing() -> None:
    line = Line(topics=('a1',), faults={'a1': '#*=not_ready:0.9'})
    run = line.run(THREE, 3)
    assert run.ended
    assert 'Suspended' not in run.states


def test_7_2_unready_station_is_not_starved_or_blocked() -> None:
    run = not_ready('a2')
    assert run.state.packml.value == 'Execute'
    assert run.state.stop_reason is None
    assert 'waiting for /a2/state = READY' in run.waits()['section 2']


def test_7_2_the_sink_comes_first_when_both_ends_wait() -> None:
    text = """
    sections:
      1: [{id: place, @a1, qty_change: 1}]
      2: [{id: pack, @a2, qty_change: -1}]
    """
    faults = {'a1': '#1=not_ready', 'a2': '#0=not_ready'}
    run = Line(2, topics=('a1', 'a2'), faults=faults).run(text, 3)
    assert run.state.stop_reason == StopReason.BLOCKED
    assert run.state.stop_message == 'pack of J/1 waits for /a2/state = READY'


def test_7_2_single_section_slot_tells_starved_from_blocked() -> None:
    text = 'sections:\n  1: [{id: place, @a1, qty_change: 1}, {id: pack, @b1, qty_change: -1}]'
    for component, reason in (('a1', StopReason.STARVED), ('b1', StopReason.BLOCKED)):
        line = Line(1, topics=(component,), faults={component: '#0=not_ready'})
        assert line.run(text, 1).state.stop_reason is reason


def test_7_2_paused_suspended_cell_returns_to_suspended() -> None:
    run = not_ready('a1')
    run.command(Pause)
    run.go()
    assert run.state.packml.value == 'Held'
    run.command(Resume)
    run.go(until=run.now + 10)
    assert run.state.packml.value == 'Suspended'


def test_7_2_suspended_cell_continues_with_startable_work() -> None:
    run = not_ready('a1')
    assert run.remove('J/1').accepted
    run.go()
    assert run.state.packml.value == 'Suspended'
    assert run.starts('pack') == []
