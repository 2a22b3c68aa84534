"""Holds that are answered as was said beforehand."""

from __future__ import annotations

import pytest
from fakes.line import THREE, Line, with_section

from bt_orchestrator.model import events as e
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.sim.simulation import Outcome, Simulation
from bt_orchestrator.sim.standing_answers import MOST_RETRIES, StandingAnswers
from bt_orchestrator.store.memory import MemoryStore


class Answered:
    """A run with an operator who answers the same every time."""

    def __init__(
        self,
        line: Line,
        text: str,
        answers: list[str],
        after_s: float = 0.0,
        results: dict[str, dict[str, object]] | None = None,
    ) -> None:
        self.store = MemoryStore()
        simulation = Simulation(line.cell, line.types, self.store)
        simulation.submit([Job('J', line.script(text), 3)])
        operator = StandingAnswers(simulation, answers, after_s, 'Ann', results)
        self.outcome = simulation.run(operator.look)
        self.complaints = operator.complaints()
        self.job = simulation.state.ended.get('J')
        self.end_s = simulation.clock.now()
        simulation.close()

    def decisions(self) -> list[tuple[str, str, float]]:
        return [
            (event.who, event.answer, event.time)
            for event in self.store.read()
            if isinstance(event, e.OperatorDecided)
        ]


@pytest.mark.parametrize(
    ('answer', 'packed', 'rejected', 'missing'),
    [
        ('retry', 3, 0, 0),
        ('mark_done', 3, 0, 0),
        ('skip', 3, 0, 0),
        ('reject', 2, 1, 0),
    ],
)
def test_each_answer_takes_the_line_to_its_end(
    answer: str, packed: int, rejected: int, missing: int
) -> None:
    text = THREE.replace('qty_change: -1', 'qty_change: -1, runs_for: all')
    done = Answered(Line(3, faults={'a2': '#2=abort'}), text, [answer])

    assert (done.outcome, done.complaints) == (Outcome.FINISHED, [])
    assert [(who, what) for who, what, _ in done.decisions()] == [('Ann', answer)]
    assert done.job is not None
    counts = done.job.progress
    assert (counts.packed, counts.rejected, counts.missing) == (packed, rejected, missing)


def test_again_is_not_given_for_ever() -> None:
    judged = '{id: weigh, @a2, fails_unless: {value: "${results.weigh.measurement}", at_least: 1}}'
    text = with_section(2, f'- repeat: [{judged}]')
    good = Answered(Line(3, faults={'a2': '#1=reads:0 #2=reads:0 #*=reads:2'}), text, ['again'])
    assert (good.outcome, len(good.decisions())) == (Outcome.FINISHED, 1)

    bad = Answered(Line(3, faults={'a2': '#*=reads:0'}), text, ['again'])
    assert (bad.outcome, len(bad.decisions())) == (Outcome.HELD, MOST_RETRIES)


def test_an_operator_takes_time() -> None:
    line = Line(3, faults={'a2': '#1=abort'})
    quick, slow = Answered(line, THREE, ['retry']), Answered(line, THREE, ['retry'], 30.0)

    assert slow.end_s - quick.end_s == 30.0
    assert slow.decisions()[0][2] - quick.decisions()[0][2] == 30.0


def test_what_a_hold_does_not_offer_is_said() -> None:
    done = Answered(Line(3, faults={'a3': '#1=abort'}), THREE, ['skip'])

    assert done.outcome is Outcome.HELD
    assert done.complaints == [
        'hold 1 does not offer skip, but retry, mark_done, reject, abort_job'
    ]


def test_first_answer_offered_by_hold_is_given() -> None:
    done = Answered(Line(3, faults={'a3': '#1=abort'}), THREE, ['skip', 'mark_done', 'retry'])

    assert done.outcome is Outcome.FINISHED
    assert [answer for _, answer, _ in done.decisions()] == ['mark_done']


def test_answer_is_chosen_when_hold_is_raised() -> None:
    """Its item is rejected before the answer is due; then another answer is chosen."""
    beside = '{id: work, @a2}, {id: bad, @b2.TASK_B, on_failure: reject}'
    text = with_section(2, f'- parallel: [{beside}]')
    text = text.replace('qty_change: -1', 'qty_change: -1, runs_for: all')
    line = Line(3, seconds={'b2': 10.0}, faults={'a2': '#1=abort', 'b2': '#1=abort'})
    done = Answered(line, text, ['reject', 'skip'], 30.0)
    assert [(answer, time) for _, answer, time in done.decisions()] == [('skip', 64.0)]
    assert done.complaints == []
    early = Answered(line, text, ['reject', 'skip'], 5.0)
    assert [(answer, time) for _, answer, time in early.decisions()] == [('reject', 9.0)]


def test_permanent_fault_is_not_retried_forever() -> None:
    done = Answered(Line(3, faults={'a2': '#*=abort'}), THREE, ['retry'])

    assert done.outcome is Outcome.HELD
    assert len(done.decisions()) == MOST_RETRIES
    (complaint,) = done.complaints
    assert complaint.startswith(f'work of J/1 was tried again {MOST_RETRIES} times and failed')


def test_intermittent_belt_fault_is_retried_each_time() -> None:
    faults = {'conveyor': ' '.join(f'#{n}=abort' for n in range(1, 2 * MOST_RETRIES, 2))}
    done = Answered(Line(3, faults=faults), THREE, ['retry'])

    assert done.outcome is Outcome.FINISHED


def test_move_still_held_after_answer_is_reported() -> None:
    done = Answered(Line(3, faults={'conveyor': '#1=abort'}), THREE, ['abort_job'])

    assert done.outcome is Outcome.HELD
    assert done.complaints == ['hold 1 stays after abort_job; another answer has to end it']


def test_item_about_to_leave_belt_is_removed() -> None:
    line = Line(3, faults={'a2': '#1=abort'})
    text = THREE.replace('{id: work, @a2}', '{id: work, @a2, on_failure: hold}')
    done = Answered(line, text, ['reject', 'remove_item'])

    assert done.outcome is Outcome.FINISHED
    assert [answer for _, answer, _ in done.decisions()] == ['reject', 'remove_item']
    assert done.job is not None
    assert done.job.progress.missing == 1


def test_mark_done_gives_the_results_that_were_said() -> None:
    text = """
    sections:
      1: [{id: place, @a1, qty_change: 1}]
      2: [{id: look, @a2}]
      3:
        - {id: use, @a3, args: {special_argument_2: "${results.look.measurement}"}}
        - {id: pack, @b3, qty_change: -1}
    """
    line = Line(3, faults={'a2': '#2=abort'})
    done = Answered(line, text, ['mark_done'], results={'look': {'measurement': 2.5}})
    assert (done.outcome, done.complaints) == (Outcome.FINISHED, [])
    given = [
        event.args['special_argument_2']
        for event in done.store.read()
        if isinstance(event, e.TaskStarted) and event.task == 'use'
    ]
    assert given[1] == 2.5
