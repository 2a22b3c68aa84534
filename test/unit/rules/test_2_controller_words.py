"""Semantics 2.3: what a controller says of a failed attempt goes with the failure and its hold."""

from __future__ import annotations

import pytest
from fakes.commands import Abort
from fakes.line import THREE, Line
from fakes.reading import Reading
from fakes.virtual_run import VirtualRun

from bt_orchestrator.model.hold_words import hold_words
from bt_orchestrator.model.state import Hold

FEEDBACK = '{"current_sub_task": "RUN"}'


def one_hold(run: VirtualRun) -> Hold:
    (hold,) = run.state.holds.values()
    return hold


@pytest.mark.parametrize(
    ('fault', 'reason'),
    [('abort', 'aborted'), ('false', 'task_result_false'), ('cancel', 'in_doubt')],
)
def test_2_3_the_words_of_its_result_are_kept(fault: str, reason: str) -> None:
    run = Reading(faults=f'"#1={fault}:lens is dirty"').go()
    (failed,) = run.all('task.failed')
    assert (failed['reason'], failed['controller_said']) == (reason, 'code: lens is dirty')
    assert failed['last_feedback'] == FEEDBACK
    hold = one_hold(run)
    assert (hold.controller_said, hold.last_feedback) == ('code: lens is dirty', FEEDBACK)
    assert f'{reason} (the controller says: code: lens is dirty' in hold_words(hold)


def test_2_3_words_of_a_refused_result_too() -> None:
    run = Reading('lot 7').go(
        options=', fails_unless: {value: "${results.read.count}", at_least: 1}'
    )
    (failed,) = run.all('task.failed')
    assert (failed['reason'], failed['controller_said']) == ('result_refused', 'code: lot 7')


def test_2_3_an_attempt_without_words_and_feedback_records_neither() -> None:
    run = Line(faults={'a2': '#1=reject'}).run()
    (failed,) = run.all('task.failed')
    assert failed.keys().isdisjoint({'controller_said', 'last_feedback', 'topic_says', 'round'})
    (raised,) = run.all('hold.raised')
    assert raised.keys().isdisjoint({'controller_said', 'last_feedback', 'topic_says', 'round'})


def test_2_3_each_attempt_has_its_own_words() -> None:
    run = Reading(faults='"#1=abort:first", "#2=abort"').go(options=', retries: 1')
    assert [row.get('controller_said') for row in run.all('task.failed')] == ['code: first', None]
    assert one_hold(run).controller_said == ''


def test_7_2_hold_after_abort_names_what_is_unknown() -> None:
    run = Line().begin(THREE).go(until=0.5)
    run.command(Abort)
    run.go()
    hold = one_hold(run)
    assert hold.reason == 'in_doubt'
    assert hold.message.startswith(
        'after an abort of the cell: the controller cancelled the goal as asked; '
        'how far it came is not known'
    )
