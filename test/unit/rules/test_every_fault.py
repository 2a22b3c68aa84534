"""A long job under every fault that a simulated controller can have.

Each ends as the rules say, and the events tell it to someone who was not there: every failed
attempt has its reason, and what was decided about it, by a rule or by a person, follows.
"""

from __future__ import annotations

import pytest
from fakes.line import Line, with_section
from fakes.virtual_run import VirtualRun

from bt_orchestrator.model.fault import FaultKind

ITEMS = 50

# fault of section 2's component, its state topic, the reason of each failure in turn,
# the answer to each hold, packed items
CASES = [
    ('#20=false', False, ['task_result_false'], 'retry', 50),
    ('#20=reject', False, ['goal_rejected'], 'retry', 50),
    ('#20=abort', False, ['aborted'], 'mark_done', 50),
    ('#20=cancel', False, ['in_doubt'], 'skip', 50),
    ('#20=hang', False, ['timeout'], 'retry', 50),
    # The controller stays busy with the goal that it would not cancel: nothing more can be done.
    ('#20=ignore_cancel', False, ['in_doubt'], 'abort_job', None),
    ('#20=late:7', False, [], None, 50),
    ('#20=reads:4.2', False, [], None, 50),
    ('#20=late:60', False, ['timeout'], 'retry', 50),
    ('#20=mute', False, ['server_lost'], 'retry', 50),
    ('#20=die:30', False, ['server_lost'], 'retry', 50),
    ('#20=die:1', False, ['server_lost'], 'mark_done', 50),
    ('=absent:3', False, [], None, 50),
    ('=absent:30', False, ['server_unavailable'], 'skip', 50),
    ('#20=not_ready:25', True, [], None, 50),
    ('#0=not_ready:25', True, [], None, 50),
    ('#20=abort #30=abort', False, ['aborted', 'aborted'], 'reject', 48),
    ('#20=abort', False, ['aborted'], 'abort_job', None),
]


def run(faults: str, *, topic: bool) -> VirtualRun:
    line = Line(faults={'a2': faults}, topics=('a2',) if topic else ())
    text = with_section(2, '- {id: work, @a2, timeout: 20.0}')
    text = text.replace('{id: pack, @a3,', '{id: pack, @a3, runs_for: all,')
    return line.begin(text, ITEMS)


@pytest.mark.parametrize(('faults', 'topic', 'reasons', 'answer', 'packed'), CASES)
def test_2_3_a_job_of_50_items_ends_under_every_fault(
    faults: str, topic: bool, reasons: list[str], answer: str | None, packed: int | None
) -> None:
    job = run(faults, topic=topic)
    job.go()
    while job.state.holds:
        assert answer is not None, job.state.holds
        if 'absent' in faults or 'die:30' in faults:
            job.sim.clock.call_at(job.now + 40, lambda: None)  # the operator restarts the server
            job.go(until=job.now + 40)
        assert job.answer(answer).accepted
        job.go()

    assert job.ended
    assert job.reasons() == reasons
    if packed is None:
        _ends_aborted(job)
    else:
        assert job.counts()['packed'] == packed
        assert job.counts().get('rejected', 0) == ITEMS - packed
    _is_explained(job, reasons, answer)


def _ends_aborted(job: VirtualRun) -> None:
    counts = job.counts()
    assert job.order('job.aborted', 'job') == ['J']
    assert counts['packed'] + counts['rejected'] == counts['placed'] < ITEMS


def _is_explained(job: VirtualRun, reasons: list[str], answer: str | None) -> None:
    failed = job.all('task.failed')
    held = job.all('hold.raised')
    decided = job.all('operator.decided')
    assert [record['reason'] for record in held] == reasons
    assert [record['answer'] for record in decided] == [answer] * len(reasons)
    assert [record['hold'] for record in decided] == [record['hold'] for record in held]
    for attempt, hold, decision in zip(failed, held, decided, strict=True):
        assert attempt['seq'] < hold['seq'] < decision['seq']
        assert (hold['item'], hold['task']) == (attempt['item'], attempt['task'])
        assert hold.get('message') == attempt.get('message')


def test_every_kind_of_fault_is_among_the_cases() -> None:
    named = {spec.split('=')[1].split(':')[0] for case in CASES for spec in case[0].split()}
    # Nothing is ever published: the job waits for good, and says for what.
    assert named == {kind.value for kind in FaultKind} - {'silent'}
    job = run('=silent', topic=True)
    job.go()
    assert not job.ended
    assert job.waits()['section 2'] == (
        'waiting for /a2/state = READY; nothing is published there'
    )
