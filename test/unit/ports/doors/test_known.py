"""Scripts and parameters come from events, and once from a moment of the cell."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, cast

import pytest
from fakes.line import THREE, TYPES, Line
from fakes.virtual_run import BY, VirtualRun

from bt_orchestrator.engine.runtime.overview import Overview, description_of
from bt_orchestrator.extensions.page.web.page import CellShow
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job, RecipeChoice
from bt_orchestrator.model.keeping.snapshot import nearest, state_to_plain
from bt_orchestrator.ports import Moment
from bt_orchestrator.ports.doors.known import MOST_SCRIPTS, Known, told_by

LOT = 'params: {lot: {type: str, default: none}}\n' + THREE


@pytest.fixture
def run() -> Iterator[VirtualRun]:
    line = Line(3)
    run = VirtualRun(line.cell, line.types)
    run.submit('J', line.script(LOT), 1, lot='A7')
    run.go(until=1.5)
    yield run
    run.sim.close()


def shown(run: VirtualRun, show: CellShow) -> dict[str, Any]:
    status = Overview(run.sim.orchestrator).status(run.now)
    return cast(
        'dict[str, Any]', show.parts(status, description_of(run.state.cell, TYPES), '/node')
    )


def test_events_tell_scripts_and_parameters(run: VirtualRun) -> None:
    known = Known()
    show = CellShow(known)
    for event in run.store.read():
        show.hear(event)
    parts = shown(run, show)
    assert parts['job/J']['params'] == {'lot': 'A7'}
    assert parts['job/J']['choice'] is None
    assert [task['id'] for task in parts['section/1']['tasks']] == ['place']
    assert not show.wants_moment


def test_order_by_recipe_is_kept_as_given(run: VirtualRun) -> None:
    choice = RecipeChoice(('P-1', 'P-2'), None, {'glue': 'press'})
    run.ask(AddJobs((Job('K', run.state.script('J'), 1, {'lot': 'B'}, recipe=choice),), BY))
    heard, restored = Known(), Known()
    for event in run.store.read():
        heard.hear(event)
    state = nearest(run.state)
    restored.take(told_by(Moment(run.state.cell, state_to_plain(state), run.now)))
    assert heard.orders['K'] == restored.orders['K'] == ({'lot': 'B'}, choice)
    plain = {'recipes': ['P-1', 'P-2'], 'version': None, 'bind': {'glue': 'press'}}
    assert shown(run, CellShow(heard))['job/K']['choice'] == plain


def test_moment_adds_earlier_state_and_is_requested_once(run: VirtualRun) -> None:
    known = Known()
    show = CellShow(known)
    assert shown(run, show)['section/1']['tasks'] == []
    assert show.wants_moment
    show.wants_moment = False
    shown(run, show)
    assert not show.wants_moment, 'a script that no moment tells is not asked for again and again'
    state = nearest(run.state)
    known.take(told_by(Moment(run.state.cell, state_to_plain(state), run.now)))
    assert known.cell == run.state.cell
    parts = shown(run, show)
    assert parts['job/J']['params'] == {'lot': 'A7'}
    assert [task['id'] for task in parts['section/1']['tasks']] == ['place']


def test_new_journal_resets_jobs_and_keeps_scripts(run: VirtualRun) -> None:
    known = Known()
    show = CellShow(known)
    for event in run.store.read():
        show.hear(event)
    show.begin('another')
    parts = shown(run, show)
    assert parts['job/J']['params'] == {}
    assert digest(run.job().job.script) in known.scripts


def test_node_without_answer_is_asked_again() -> None:
    known = Known()
    assert known.lacks(['d'])
    assert not known.lacks(['d'])
    known.not_told()
    assert known.lacks(['d'])


def test_scripts_that_nobody_shows_are_forgotten_some_time(run: VirtualRun) -> None:
    known, script = Known(), run.job().job.script
    for number in range(MOST_SCRIPTS + 5):
        known.scripts[f'd{number}'] = script
    assert not known.lacks(['d1', 'd50'])
    assert len(known.scripts) == MOST_SCRIPTS + 2
    assert 'd0' not in known.scripts
    assert 'd1' in known.scripts, 'it is shown'
