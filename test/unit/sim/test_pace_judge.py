"""The expected pace, against means that can be worked out by hand (semantics 8.4)."""

from __future__ import annotations

import pytest
from fakes.line import THREE, TYPES, Line, with_section

from bt_orchestrator.model.script import Script
from bt_orchestrator.sim import pace_judge
from bt_orchestrator.sim.pace_judge import PaceJudge
from bt_orchestrator.store.memory import MemoryStore
from bt_orchestrator.view.report.pace_text import Expected
from bt_orchestrator.view.report.rates import RatesSeen, rates_of

LINE = Line(seconds={'b2': 4.0})
"""A beat of the shortest line takes 3 s: a task of 1 s, and a move of 2 s."""

MAYBE = """
  - {id: work, @a2}
  - {id: more, @b2, when: "${results.work.item_present}", likely: LIKELY}
"""


def script(section: str, line: Line = LINE, more: str = '') -> Script:
    text = with_section(2, section)
    return line.script(text.replace('qty_change: -1', 'qty_change: -1, runs_for: all') + more)


def expected(script: Script, line: Line = LINE) -> Expected | None:
    rates = list(rates_of(script, RatesSeen()))
    return PaceJudge(line.cell, TYPES, MemoryStore).expected(script, rates)


def sure(section: str, line: Line = LINE) -> Expected:
    estimate = expected(script(section, line), line)
    assert estimate is not None
    return estimate


def near(expected: Expected, mean_s: float) -> bool:
    """Tell whether a mean is where the figure says, with room for one case in twenty."""
    return abs(expected.per_item_s - mean_s) < 2 * expected.sure_s


@pytest.mark.parametrize('share', [0.0, 0.05, 0.3, 1.0])
def test_8_4_a_condition_runs_as_often_as_is_likely(share: float) -> None:
    estimate = sure(MAYBE.replace('LIKELY', str(share)))
    assert estimate.per_item_s == pytest.approx(3.0 + 4.0 * share, abs=2 * estimate.sure_s + 1e-9)
    assert estimate.sure_s == 0.0 if share in (0.0, 1.0) else 0.0 < estimate.sure_s < 0.15
    assert (estimate.items, estimate.good, estimate.holds) == (1000, 1.0, 0)


def test_8_4_unless_says_how_often_it_runs_as_well() -> None:
    section = MAYBE.replace('LIKELY', '0.3').replace('when', 'unless')
    assert near(sure(section), 3.0 + 4.0 * 0.3)


def test_8_4_tasks_with_one_condition_are_drawn_together() -> None:
    estimate = sure(
        """
        - {id: work, @a2}
        - {id: one, @b2, when: "${results.work.item_present}", likely: 0.3}
        - {id: other, @b2, unless: "${results.work.item_present}"}
        """
    )
    assert estimate.per_item_s == pytest.approx(7.0)
    assert estimate.sure_s == pytest.approx(0.0)
    assert estimate.always == ()


def test_8_4_tasks_with_different_conditions_are_drawn_independently() -> None:
    estimate = sure(
        """
        - {id: work, @a2}
        - {id: one, @b2, when: "${results.work.item_present}", likely: 0.3}
        - {id: other, @b2, when: {value: "${results.work.measurement}", at_least: 1}, likely: 0.7}
        """
    )
    assert near(estimate, 3.0 + 4.0)
    assert estimate.sure_s > 0.05


def test_8_4_condition_without_rate_is_reported_and_always_met() -> None:
    estimate = sure(
        """
        - {id: work, @a2}
        - {id: one, @b2, when: "${results.work.item_present}", likely: 0.0}
        - {id: other, @b2, when: {value: "${results.work.measurement}", at_least: 1}}
        """
    )
    assert estimate.per_item_s == pytest.approx(7.0)
    assert estimate.always == ('other',)
    assert '  no `likely`, so counted as always run: other' in list(estimate.lines())


def test_8_4_a_failed_attempt_is_made_again() -> None:
    estimate = sure('- {id: work, @b2, retries: 3, on_failure: reject, likely: 0.2}')
    assert near(estimate, 2.0 + 4.0 * (1 + 0.2 + 0.04 + 0.008))
    assert estimate.good == pytest.approx(1 - 0.2**4, abs=0.005)


def test_8_4_rejected_items_appear_in_good_item_pace() -> None:
    estimate = sure('[{id: look, @a2, on_failure: reject, likely: 0.25}, {id: work, @b2}]')
    assert near(estimate, 3.0 + 4.0 * 0.75)
    assert estimate.good == pytest.approx(0.75, abs=0.04)
    assert estimate.per_good_s == pytest.approx(estimate.per_item_s / estimate.good)
    assert f', {estimate.per_good_s:.2f} s per good item' in next(estimate.lines())


def test_8_4_items_that_continue_after_failure_are_not_good() -> None:
    estimate = sure('[{id: look, @a2, on_failure: continue, likely: 0.25}, {id: work, @b2}]')
    assert estimate.per_item_s == pytest.approx(7.0)
    assert estimate.good == pytest.approx(0.75, abs=0.04)


REWORK = """
  - repeat:
    - {id: work, @b2}
    - {id: look, @a2, fails_unless: "${results.look.item_present}", on_failure: POLICY,
       likely: 0.2}
    times: 2
"""


def test_8_4_repeat_follows_refusal_rate_of_its_verdict() -> None:
    estimate = sure(REWORK.replace('POLICY', 'reject'))
    assert near(estimate, 2.0 + 5.0 * (1 + 0.2 + 0.04))
    assert estimate.good == pytest.approx(1 - 0.2**3, abs=0.01)
    assert estimate.holds == 0


def test_8_4_held_failure_is_answered_at_once() -> None:
    estimate = sure(REWORK.replace('POLICY', 'hold'))
    assert near(estimate, 2.0 + 5.0 * (1 + 0.2 + 0.04))
    assert estimate.holds == pytest.approx(1000 * 0.2**3, abs=7)
    assert 'answered at once: waiting is not counted' in list(estimate.lines())[-1]


def test_8_4_waits_for_what_sections_share_are_in_it() -> None:
    line = Line(seconds={'arm': 4.0})
    text = """
    sections:
      1: [{id: place, @a1, qty_change: 1}]
      2: [{id: look, @a2}, {id: lift, @arm, when: "${results.look.item_present}", likely: 1}]
      3: [{id: turn, @arm.TASK_B}, {id: pack, @a3, qty_change: -1}]
    """
    estimate = expected(line.script(text), line)
    assert estimate is not None
    assert estimate.per_item_s == pytest.approx(
        PaceJudge(line.cell, TYPES, MemoryStore).pace_s(line.script(text))
    )


def test_8_4_it_is_the_same_every_time() -> None:
    section = MAYBE.replace('LIKELY', '0.3')
    assert sure(section) == sure(section)


def test_8_4_estimate_ignores_faults_of_the_cell_file() -> None:
    line = Line(seconds={'b2': 4.0}, faults={'a2': '#3=abort', 'b2': '#*=late:9'})
    section = MAYBE.replace('LIKELY', '0.3')
    assert sure(section, line).per_item_s == sure(section).per_item_s


def test_8_4_long_script_gets_fewer_items_or_no_figure(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(pace_judge, 'MOST_TASKS', 400)
    assert sure(MAYBE.replace('LIKELY', '0.3')).items == 100
    monkeypatch.setattr(pace_judge, 'MOST_TASKS', 60)
    assert expected(script(MAYBE.replace('LIKELY', '0.3'))) is None


def test_8_4_nothing_likely_is_no_figure() -> None:
    assert list(rates_of(LINE.script(THREE), RatesSeen())) == []
