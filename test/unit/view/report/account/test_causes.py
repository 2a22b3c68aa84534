"""The causes of scrap and rework of small lines, each as docs/account.md says it."""

from __future__ import annotations

import json
from typing import Any

import pytest
from fakes.line import Line, with_section
from fakes.virtual_run import VirtualRun

from bt_orchestrator.model.codec import from_record, json_of
from bt_orchestrator.view.report.account.causes.flaws import flaw_words
from bt_orchestrator.view.report.account.course import Course
from bt_orchestrator.view.report.account.fold import FOLLOWED, AccountFold
from bt_orchestrator.view.report.account.planned import Planned
from bt_orchestrator.view.report.account.total import Times

VERDICT = (
    'fails_unless: {all: [{value: "${results.work.measurement}", between: [1.0, 2.0]}, '
    '"${results.work.item_present}"]}'
)
BOUND = '${results.work.measurement} from 1.0 to 2.0'


class Told:
    """Keeps what a course says of items."""

    def __init__(self) -> None:
        self.told: list[Any] = []

    def happened(self, what: Any) -> None:
        self.told.append(what)

    def _nothing(self, *_: Any, **__: Any) -> None:
        """Leave all else out."""

    passes = raised = released = failed = runs = _nothing


def times(run: VirtualRun) -> Times:
    fold = AccountFold(Planned.of([(0, 10**12)]), is_whole=True)
    for record in run.records:
        if record['event'] in FOLLOWED:
            fold.follow(from_record(record))
    return fold.until(10**12)


def causes(run: VirtualRun) -> list[tuple[str, str, int]]:
    flaws = times(run).flaws
    return [(flaw.of.effect.value, flaw_words(flaw.of), flaw.times) for flaw in flaws]


def run_of(line: Line, keys: str, *answers: str, quantity: int = 1) -> VirtualRun:
    """Run a job whose section 2 does one task with some keys, and answer its holds."""
    text = with_section(2, f'- {{id: work, @a2, {keys}}}')
    run = line.begin(text.replace('qty_change: -1', 'qty_change: -1, runs_for: all'), quantity)
    run.go()
    for answer in answers:
        run.answer(answer)
        run.go()
    assert run.ended
    return run


def test_verdict_rejects_and_names_failed_bound() -> None:
    line = Line(results={'a2': {'measurement': 2.5, 'item_present': True}})
    run = run_of(line, f'on_failure: reject, {VERDICT}')
    why = f'work at a2 result_refused ({BOUND}), by the script'
    assert causes(run) == [('rejected', why, 1)]
    (measured,) = times(run).measured
    assert (measured.times, measured.below, measured.above) == (1, 0, 1)
    assert (measured.least, float(measured.mean), measured.greatest) == (2.5, 2.5, 2.5)


@pytest.mark.parametrize(
    ('answers', 'steps', 'first_pass'),
    [
        (('reject',), [('rejected', f'work at a2 result_refused ({BOUND}), answer reject', 1)], 0),
        (
            ('mark_done',),
            [('nonconforming', f'work at a2 result_refused ({BOUND}), answer mark_done', 1)],
            0,
        ),
        (
            ('skip',),
            [('nonconforming', f'work at a2 result_refused ({BOUND}), answer skip', 1)],
            0,
        ),
        (('abort_job',), [('rejected', 'abort_job', 1)], 0),
        (
            ('retry', 'reject'),
            [
                ('attempt', f'work at a2 result_refused ({BOUND}), answer retry', 1),
                ('rejected', f'work at a2 result_refused ({BOUND}), answer reject', 1),
            ],
            0,
        ),
    ],
)
def test_answers_are_decisions(
    answers: tuple[str, ...], steps: list[tuple[str, str, int]], first_pass: int
) -> None:
    line = Line(results={'a2': {'measurement': 0.5, 'item_present': True}})
    run = run_of(line, VERDICT, *answers)
    assert causes(run) == steps
    assert sum(made.first_pass for made in times(run).made) == first_pass


def test_retry_by_script_is_rework_not_first_pass() -> None:
    run = run_of(Line(faults={'a2': '#1=abort'}), 'retries: 1', quantity=2)
    assert causes(run) == [('attempt', 'work at a2 aborted, by the script', 1)]
    (made,) = times(run).made
    assert (made.good, made.first_pass, made.attempts, made.rounds) == (2, 1, 1, 0)


def test_repeat_rounds_name_verdict_that_began_them() -> None:
    line = Line(results={'a2': {'measurement': 9.0, 'item_present': True}})
    text = with_section(
        2,
        f'- repeat: [{{id: work, @a2, on_failure: continue, {VERDICT}}}]\n  times: 2',
    )
    run = line.run(text)
    why = f'work at a2 result_refused ({BOUND}), by the script'
    assert causes(run) == [('round', why, 2), ('nonconforming', why, 1)]
    (made,) = times(run).made
    assert (made.nonconforming, made.first_pass, made.rounds) == (1, 0, 2)


def test_course_restored_at_every_event_agrees() -> None:
    """At every event: the causes are those of a course that was never kept."""
    line = Line(results={'a2': {'measurement': 9.0, 'item_present': True}})
    text = with_section(
        2,
        f'- repeat: [{{id: work, @a2, {VERDICT}}}]\n  times: 1',
    )
    run = line.begin(text, 2)
    run.go()
    for answer in ('again', 'retry', 'reject', 'mark_done'):
        run.answer(answer)
        run.go()
    events = [from_record(record) for record in run.records if record['event'] in FOLLOWED]
    straight, kept = Told(), Told()
    course = other = Course(is_whole=True)
    for event in events:
        course.follow(event, straight)
        other.follow(event, kept)
        other = Course.from_plain(json.loads(json_of(other.plain())))
    assert straight.told == kept.told
    assert len(straight.told) > 6
