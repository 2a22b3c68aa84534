"""The pace in closed form, against what the engine does (semantics 8.4)."""

from __future__ import annotations

import random
from collections import Counter
from dataclasses import replace
from fractions import Fraction

import pytest
from fakes.drawn.lines import lines
from fakes.drawn.plan import Plan, Traits
from fakes.flagged_line import FlaggedLine
from fakes.line import THREE, Line, with_section
from fakes.plan_runs import product_cell, product_scripts, show
from fakes.profiles import examples
from fakes.steady import steady
from hypothesis import given
from hypothesis import strategies as st

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.proof.pace import Pace, PacedLine, pace
from bt_orchestrator.model.proof.quicker import Quicker, quicker, roomier
from bt_orchestrator.sim.pace_judge import PaceJudge
from bt_orchestrator.store.memory import MemoryStore
from bt_orchestrator.view.report.rates import RatesSeen, rates_of

pytestmark = pytest.mark.timeout(24 * 3600)

SEEDS = st.integers(0, 2**32)
SECONDS = (0.0, 0.5, 1.0, 2.5, 3.25, 7.0)
"""Sums of few of them differ, or are equal, by more than a run of some items hides."""


def drawn_durations(cell: Cell, seed: int) -> Cell:
    """Return a cell in which each task of each component takes some other time."""
    draw = random.Random(seed)
    tasks = ('TASK_A', 'TASK_B', cell.conveyor.task)
    components = {
        name: replace(device, durations_s={task: draw.choice(SECONDS) for task in tasks})
        for name, device in cell.components.items()
    }
    conveyor = replace(cell.conveyor, component=components[cell.conveyor.component.name])
    return replace(cell, components=components, conveyor=conveyor)


def paced(line: Line, text: str) -> Pace:
    line_pace = pace(line.script(text), line.cell)
    assert line_pace is not None
    return line_pace


# --- lists and the belt ---------------------------------------------------------------------

AHEAD = with_section(
    2, '[{id: free, @b2, requires_conveyor: false}, {id: work, @a2}, {id: more, @b2.TASK_B}]'
)
SOURCE_AHEAD = with_section(
    1, '[{id: pick, @b1, requires_conveyor: false}, {id: place, @a1, qty_change: 1}]'
)
GROUP = with_section(2, '[{parallel: [{id: work, @a2}, [{id: x, @b2}, {id: y, @b2.TASK_B}]]}]')
RELEASE = with_section(
    2,
    """
      release_conveyor: after_last_conveyor_task
      tasks: [{id: work, @a2}, {id: clean, @b2, requires_conveyor: false}]
    """,
)
REJECTED = with_section(2, '[{id: work, @a2}, {id: drop, @b2, runs_for: rejected}]')
ALONE = 'sections: {1: [{id: place, @a1, qty_change: 1}, {id: pack, @a1, qty_change: -1}]}'


@pytest.mark.parametrize(
    ('text', 'slow', 'per_item_s', 'limit'),
    [
        (THREE, 'a2', 9.0, 'work + index move'),
        (AHEAD, 'a2', 10.0, 'work + more + index move'),
        (AHEAD, 'b2', 15.0, 'free + work + more'),
        (SOURCE_AHEAD, 'b1', 8.0, 'pick + place'),
        (SOURCE_AHEAD, 'a1', 9.0, 'place + index move'),
        (GROUP, 'a2', 9.0, 'work + index move'),
        (GROUP, 'b2', 16.0, 'x + y + index move'),
        (RELEASE, 'a2', 9.0, 'work + index move'),
        (RELEASE, 'b2', 8.0, 'work + clean'),
        (REJECTED, 'b2', 3.0, 'place + index move'),
        (ALONE, 'a1', 14.0, 'place + pack'),  # nothing stands on the belt, so it does not move
    ],
)
def test_8_4_the_slowest_circle_is_the_pace(
    text: str, slow: str, per_item_s: float, limit: str
) -> None:
    line = Line(seconds={slow: 7.0})
    actual_pace = paced(line, text)
    assert (actual_pace.per_item_s, str(actual_pace.limit)) == (per_item_s, limit)
    assert actual_pace.is_exact
    assert steady(line.cell, line.script(text)) == (per_item_s, True)


def test_8_4_line_without_durations_has_no_limit() -> None:
    cell = Line(seconds=dict.fromkeys(('a1', 'a2', 'a3'), 0.0)).cell
    still = replace(cell.conveyor.component, default_duration_s=0.0)
    cell = replace(cell, components={**cell.components, still.name: still})
    actual_pace = pace(Line().script(THREE), cell)
    assert actual_pace is not None
    assert str(actual_pace) == 'pace: 0.0 s per item, limited by nothing that takes time'
    assert quicker(PacedLine(Line().script(THREE), cell), cell) is None


# --- flags ----------------------------------------------------------------------------------

COUPLED = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: look, @a2}, {id: turn, @b2}]
  3: [{id: fill, @a3}, {id: close, @b3}]
  4: [{id: pack, @a4, qty_change: -1}]
lateral_dependencies:
  - {flag: turned, upstream: UP, downstream: DOWN, capacity: CAPACITY, initial: INITIAL}
"""


@pytest.mark.parametrize(
    ('up', 'down', 'capacity', 'initial', 'per_item_s', 'limit'),
    [
        ('turn', 'fill', 2, 0, 8.0, 'look + turn + index move'),
        # The item in section 3 is filled before that in section 2 is turned.
        ('turn', 'fill', 1, 0, 10.0, 'fill + turn + index move (flag turned)'),
        ('look', 'close', 1, 0, 13.0, 'fill + close + look + turn + index move (flag turned)'),
        # Section 3 works on its item first, in each beat.
        ('close', 'look', 1, 1, 13.0, 'fill + close + look + turn + index move (flag turned)'),
        ('close', 'look', 2, 2, 8.0, 'look + turn + index move'),
    ],
)
def test_8_4_a_flag_puts_sections_into_one_circle(
    up: str, down: str, capacity: int, initial: int, per_item_s: float, limit: str
) -> None:
    text = COUPLED
    for name, value in {'UP': up, 'DOWN': down, 'CAPACITY': capacity, 'INITIAL': initial}.items():
        text = text.replace(name, str(value))
    line = Line(4, seconds={'b2': 5.0, 'a3': 3.0, 'b3': 2.0})
    actual_pace = paced(line, text)
    assert (actual_pace.per_item_s, str(actual_pace.limit)) == (per_item_s, limit)
    assert steady(line.cell, line.script(text)) == (per_item_s, True)


def test_8_4_lines_without_shared_spaces_match_predicted_pace() -> None:
    """And the pace is infinite exactly if the line gets stuck."""
    seen: Counter[str] = Counter()

    @examples(20, 2000)
    @given(SEEDS)
    def holds(seed: int) -> None:
        drawn = FlaggedLine(seed)
        cell = drawn_durations(drawn.line.cell, seed)
        predicted, real = pace(drawn.script, cell), steady(cell, drawn.script)
        assert (predicted is None) == (real is None), drawn.text
        if predicted is not None and real is not None:
            assert predicted.is_exact
            assert real.repeats, drawn.text
            assert abs(real.per_item_s - predicted.per_item_s) < 1e-6, drawn.text
        seen['all'] += 1
        seen['stuck'] += predicted is None
        seen['by flags'] += predicted is not None and bool(predicted.limit.flags)

    holds()
    assert min(seen['stuck'], seen['by flags']) > 0, seen


# --- what there is only one of --------------------------------------------------------------

ARM = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: near, @arm}]
  3: [{id: far, @arm}, {id: pack, @a3, qty_change: -1}]
"""
ZONE = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{parallel: [{id: left, @a2}, {id: right, @b2}]}]
  3: [{id: pack, @a3, qty_change: -1}]
zones:
  table: [left, right]
"""
ONE_AFTER_THE_OTHER = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: first, @a2}, {id: second, @a2}]
  3: [{id: pack, @a3, qty_change: -1}]
zones:
  table: [first, second]
"""
BELT_AS_A_TOOL = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2:
    release_conveyor: after_last_conveyor_task
    tasks: [{id: work, @a2}, {id: push, task: HOME, action: /belt/do, requires_conveyor: false}]
  3: [{id: pack, @a3, qty_change: -1}]
"""


def test_8_4_what_is_shared_makes_the_pace_a_bound() -> None:
    line = Line(seconds={'arm': 4.0})
    bound = paced(line, ARM)
    assert (bound.per_item_s, str(bound.limit)) == (8.0, 'near + far, never two at once (arm)')
    assert bound.not_counted == ('waits for arm',)
    assert not bound.is_exact
    real = steady(line.cell, line.script(ARM))
    assert real is not None
    assert real.per_item_s > 8.0  # the belt waits for both, and moves while the arm does nothing


def test_8_4_further_rounds_of_a_repeat_are_not_counted() -> None:
    judged = 'fails_unless: "${results.look.item_present}"'
    repeat = f'- repeat: [{{id: glue, @b2}}, {{id: look, @a2, {judged}}}]'
    actual_pace = paced(Line(), with_section(2, repeat))
    assert actual_pace.per_item_s == 4.0
    assert actual_pace.not_counted == ('further rounds of glue',)
    assert str(actual_pace).startswith(
        'pace: 4.0 s per item or longer (further rounds of glue not counted'
    )
    assert not actual_pace.is_exact


def test_8_4_two_group_tracks_may_want_one_zone() -> None:
    actual_pace = paced(Line(), ZONE)
    assert actual_pace.not_counted == ('waits for zone table',)
    assert paced(Line(), ONE_AFTER_THE_OTHER).is_exact


def test_8_4_conveyor_task_waits_for_index_moves() -> None:
    actual_pace = paced(Line(), BELT_AS_A_TOOL)
    assert (actual_pace.per_item_s, str(actual_pace.limit)) == (
        4.0,
        'index move + push, never two at once (conveyor)',
    )


# --- conditions -----------------------------------------------------------------------------

SEALED = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: look, @a2}, {id: seal, @b2, WHEN: {value: "${item.number}", equals: 1}}]
  3: [{id: pack, @a3, qty_change: -1}]
"""


@pytest.mark.parametrize(('word', 'real_s'), [('when', 3.0), ('unless', 8.0)])
def test_8_4_tasks_with_conditions_leave_a_range(word: str, real_s: float) -> None:
    line = Line(seconds={'b2': 5.0})
    text = SEALED.replace('WHEN', word)
    actual_pace = paced(line, text)
    assert (actual_pace.least.per_item_s, actual_pace.per_item_s) == (3.0, 8.0)
    assert str(actual_pace.limit) == 'look + seal + index move'
    assert not actual_pace.is_exact
    assert steady(line.cell, line.script(text)) == (real_s, True)


def test_8_4_irrelevant_condition_leaves_pace_exact() -> None:
    actual_pace = paced(Line(seconds={'b2': 5.0, 'a3': 6.0}), SEALED.replace('WHEN', 'when'))
    assert (actual_pace.per_item_s, actual_pace.is_exact) == (8.0, True)


def test_8_4_no_line_is_faster_than_its_pace() -> None:
    """Lines with shared spaces and conditions, whatever else a script may say."""
    seen: Counter[str] = Counter()

    @examples(40, 2000)
    @given(lines(Traits(faults=False, most_sections=5)))
    def holds(plan: Plan) -> None:
        show(plan)
        cell = product_cell(plan)
        for script in product_scripts(plan, cell).values():
            predicted = pace(script, cell)
            is_shared = predicted is not None and bool(predicted.not_counted)
            real = steady(cell, script, at_most=60 if is_shared else 480)
            seen['stuck'] += predicted is None
            if predicted is None or real is None:
                assert predicted is not None or real is None
                continue
            slack_s = 1e-6 if real.repeats else predicted.per_item_s / 10
            assert real.per_item_s >= predicted.least.per_item_s - slack_s
            if not predicted.not_counted:
                assert real.repeats
                assert real.per_item_s <= predicted.per_item_s + slack_s
            seen['all'] += 1
            seen['exact'] += predicted.is_exact
            seen['shared'] += is_shared
            seen['slower'] += real.per_item_s > predicted.per_item_s + slack_s

    holds()
    assert min(seen['exact'], seen['shared']) > 0, seen
    assert seen['slower'] >= 0.03 * seen['all'] or seen['all'] < 200, seen


# --- what would make it faster --------------------------------------------------------------


def quickest(line: Line, text: str) -> Quicker:
    gain = quicker(PacedLine(line.script(text), line.cell), line.cell)
    assert gain is not None
    return gain


@pytest.mark.parametrize(
    ('text', 'seconds', 'words'),
    [
        (
            THREE,
            {'a2': 7.0, 'a3': 5.5},
            (
                'With work 1.5 s faster the pace would be 7.5 s per item, '
                'limited by pack + index move.'
            ),
        ),
        (THREE, {}, 'Speeding up place alone does not help: work + index move take as long.'),
        (ALONE, {'a1': 2.0}, 'Without place the pace would be 2.0 s per item, limited by pack.'),
        (
            AHEAD,
            {'b2': 7.0},
            (
                'With free 5.0 s faster the pace would be 10.0 s per item, '
                'limited by work + more + index move.'
            ),
        ),
    ],
)
def test_8_4_what_a_quicker_task_brings_is_told(
    text: str, seconds: dict[str, float], words: str
) -> None:
    assert str(quickest(Line(seconds=seconds), text)) == words


def test_8_4_task_saves_until_its_circles_stop_limiting() -> None:
    """Less is not enough, and more brings nothing."""
    seen: Counter[str] = Counter()

    @examples(40, 2000)
    @given(SEEDS)
    def holds(seed: int) -> None:
        drawn = FlaggedLine(seed)
        cell = drawn_durations(drawn.line.cell, seed)
        line = PacedLine(drawn.script, cell)
        gain = quicker(line, cell)
        if gain is None:
            return
        us, saved = line.durations(cell), round(gain.by_s * 1_000_000)

        def limit_us(left_us: int) -> Fraction:
            return line.limit({**us, gain.task: left_us}).per_item_us

        left_us = us[gain.task] - saved
        assert limit_us(left_us) == limit_us(0) == gain.then.per_item_us
        assert not saved or limit_us(left_us + 1) > gain.then.per_item_us
        seen['saves'] += bool(saved)

    holds()
    assert seen['saves'] > 5, seen


def test_8_4_useful_larger_flag_capacity_is_reported() -> None:
    """The engine goes as fast with it; and a flag that limits nothing is not named."""
    line = Line(4, seconds={'b2': 5.0, 'a3': 3.0, 'b3': 2.0})
    text = COUPLED.replace('UP', 'look').replace('DOWN', 'close').replace('INITIAL', '0')
    hint = roomier(PacedLine(line.script(text.replace('CAPACITY', '1')), line.cell), line.cell)
    assert hint is not None
    words = (
        'With capacity 2 of flag turned the pace would be 8.0 s per item, '
        'limited by look + turn + index move.'
    )
    assert str(hint) == words
    larger = line.script(text.replace('CAPACITY', '2'))
    assert steady(line.cell, larger) == (8.0, True)
    assert roomier(PacedLine(larger, line.cell), line.cell) is None


# --- what is likely -------------------------------------------------------------------------

MAYBE = """[{id: work, @a2}, {id: more, @b2, when: "${results.work.item_present}"LIKELY}]"""


def test_8_4_what_is_likely_is_between_best_and_worst() -> None:
    line = Line(seconds={'b2': 4.0})
    script = line.script(with_section(2, MAYBE.replace('LIKELY', ', likely: 0.25')))
    bounds = pace(script, line.cell)
    assert bounds is not None
    judge = PaceJudge(line.cell, line.types, MemoryStore)
    expected = judge.expected(script, list(rates_of(script, RatesSeen())))
    assert expected is not None
    assert bounds.least.per_item_s < expected.per_item_s < bounds.per_item_s
    assert expected.per_item_s == pytest.approx(4.0, abs=2 * expected.sure_s)


def test_8_4_what_is_likely_changes_nothing_else() -> None:
    line = Line(seconds={'b2': 4.0})
    with_it, without = (
        line.script(with_section(2, MAYBE.replace('LIKELY', text))) for text in (', likely: 1', '')
    )
    assert with_it.likely != without.likely
    assert digest(with_it) == digest(without)
    assert pace(with_it, line.cell) == pace(without, line.cell)
    assert line.run(with_section(2, MAYBE.replace('LIKELY', ', likely: 0'))).starts('more') == [
        4.0
    ]
