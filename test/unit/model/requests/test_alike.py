"""Which holds one list may answer."""

from __future__ import annotations

import pytest

from bt_orchestrator.model.frozen import changed
from bt_orchestrator.model.requests.offers import alike, together, why_singly
from bt_orchestrator.model.script import Task
from bt_orchestrator.model.state import Hold

TASK = ('retry', 'mark_done', 'skip', 'reject', 'abort_job')
WORK = Task('work', 'TASK_A', '/a2/task', 'a2')


def hold(
    id_: str,
    answers: tuple[str, ...] = TASK,
    reason: str = 'in_doubt',
    job: str | None = 'J',
    task: Task = WORK,
) -> Hold:
    held = Hold(id_, job, 2, 'J/1', 'work', reason, '', answers, 0.0)
    return changed(held, answers_together=together(held, task, answers))


def groups(*holds: Hold) -> list[list[str]]:
    return [[member.id for member in group] for group in alike(holds)]


def test_tasks_in_doubt_are_alike_despite_offered_answers() -> None:
    topic = ('mark_done', 'retry', 'skip', 'reject', 'abort_job')
    assert groups(hold('1'), hold('2', topic), hold('3')) == [['1', '2', '3']]
    assert groups(hold('1')) == []


@pytest.mark.parametrize(
    'other',
    [
        hold('2', task=changed(WORK, qty_change=1)),
        hold('2', task=changed(WORK, qty_change=-1)),
        hold('2', reason='aborted'),
        hold('2', ('retry', 'mark_done', 'abort_job'), job=None),
        Hold('2', None, None, None, None, 'paused', '', ('resume',), 0.0),
    ],
)
def test_moves_and_certain_failures_are_answered_singly(other: Hold) -> None:
    assert groups(hold('1'), other) == []
    assert 'answer it singly' in why_singly(other, 'mark_done')


def test_list_answers_task_that_moves_no_item() -> None:
    rejected = hold('2', ('mark_done', 'skip'))  # in a job that is being aborted
    assert groups(hold('1', ('mark_done', 'skip')), rejected) == [['1', '2']]


@pytest.mark.parametrize('answer', ['retry', 'abort_job', 'again'])
def test_what_moves_something_is_answered_singly(answer: str) -> None:
    assert 'a list can answer it with mark_done, skip, reject' in why_singly(hold('1'), answer)
    assert why_singly(hold('1'), 'mark_done') == ''
