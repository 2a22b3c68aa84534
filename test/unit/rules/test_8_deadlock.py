"""The deadlock proof, against what really happens on the line (semantics 8.2)."""

from __future__ import annotations

import random
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise, product
from typing import NamedTuple

import pytest
from fakes.action_types import FakeActionTypes
from fakes.flagged_line import FlaggedLine, SharingScripts, line_of
from fakes.line import Line
from fakes.profiles import examples
from fakes.shipped import REFERENCE_CELL, STUCK
from fakes.virtual_run import defaults
from hypothesis import example, given
from hypothesis import strategies as st

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.goal import GoalRequest
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.proof.deadlock import Deadlock, deadlock, get_stuck_together
from bt_orchestrator.model.script import Dependency, Script
from bt_orchestrator.script.cell_file import read_cell
from bt_orchestrator.script.script_file import read_script
from bt_orchestrator.sim.simulation import Outcome, Simulation
from bt_orchestrator.store.memory import MemoryStore

pytestmark = pytest.mark.timeout(24 * 3600)

TYPES = FakeActionTypes()
SEEDS = st.integers(0, 2**32)


class Run(NamedTuple):
    """How a run of the compiled tree ended."""

    finished: bool
    beat: int
    waits: dict[str, set[str]]
    """What each part waits for at the end, in words."""
    begun: int
    """Items that the source has begun."""


def run(cell: Cell, script: Script, quantity: int, seed: int | None = None) -> Run:
    """Run a whole script; with a seed, with random durations."""
    drawn = random.Random(seed)

    def duration(_: GoalRequest) -> float:
        return 1.0 if seed is None else drawn.choice([0.0, 0.5, 1.0, 7.0, 40.0])

    simulation = Simulation(cell, TYPES, MemoryStore(), duration=duration)
    simulation.submit([Job('J', script, quantity, defaults(script))])
    outcome = simulation.run()
    assert outcome is not Outcome.HELD
    state, waits = simulation.state, simulation.waits()
    simulation.close()
    words: dict[str, set[str]] = {}
    for wait in waits:
        words.setdefault(wait.part, set()).update(wait.reason.replace('J/', 'item ').split('; '))
    begun = state.jobs['J'].progress.started if 'J' in state.jobs else quantity
    return Run(outcome is Outcome.FINISHED, state.beat, words, begun)


def flagged(upstream: int, downstream: int, **dependency: int) -> str:
    """Return a script for five sections whose flag couples two of the inner ones."""
    listed = ''.join(f', {key}: {value}' for key, value in dependency.items())
    return f"""
sections:
  1: [{{id: place, @a1, qty_change: 1}}]
  2: [{{id: t2, @a2}}]
  3: [{{id: t3, @a3}}]
  4: [{{id: t4, @a4}}]
  5: [{{id: pack, @a5, qty_change: -1}}]
lateral_dependencies:
  - {{flag: coupled, upstream: t{upstream}, downstream: t{downstream}{listed}}}
"""


def test_8_2_neighbours_need_no_more_than_capacity_one() -> None:
    assert deadlock(Line(5).script(flagged(2, 3))) is None


def test_8_2_deadlock_message_describes_the_circle() -> None:
    stall = deadlock(read_script(STUCK, read_cell(REFERENCE_CELL, TYPES), TYPES))
    assert stall is not None
    assert str(stall) == (
        'the line gets stuck with stuck, at item 4 in beat 3: '
        'section 2 is waiting for assemble to take flag read_before_assemble; '
        'section 4 is waiting for an item; '
        'belt is waiting for section 2 to finish with item 2'
    )
    assert stall.hint == 'capacity 2 of flag read_before_assemble frees it'


def test_8_2_circle_within_section_leaves_belt_out() -> None:
    text = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: late, @a2}, {id: early, @b2}]
  3: [{id: pack, @a3, qty_change: -1}]
lateral_dependencies:
  - {flag: own, upstream: early, downstream: late}
"""
    stall = deadlock(Line(3).script(text))
    assert stall is not None
    assert [str(stand) for stand in stall.circle] == [
        'section 2 is waiting for early to set flag own'
    ]
    assert stall.remedy == 'initial count 1 of flag own frees it'


def test_8_2_circle_through_tracks_names_each_wait() -> None:
    """The flag of the first is no remedy, which it would be alone."""
    text = """
sections:
  1:
    - {id: place, @a1, qty_change: 1}
    - parallel: [[{id: hold, @a1}], [{id: turn, @b1}]]
    - {id: pack, @b1, qty_change: -1}
lateral_dependencies:
  - {flag: turned, upstream: turn, downstream: hold}
  - {flag: packed, upstream: pack, downstream: turn}
"""
    stall = deadlock(Line(1).script(text))
    assert stall is not None
    assert [str(stand) for stand in stall.circle] == [
        'section 1 is waiting for turn to set flag turned',
        'section 1 is waiting for pack to set flag packed',
    ]
    assert stall.remedy == 'initial count 1 of flag packed frees it'


def test_8_2_a_circle_through_a_long_list_is_told() -> None:
    inner = [f't{number}' for number in range(1500)]
    tasks = ''.join(f'    - {{id: {task}, @a1}}\n' for task in inner)
    flags = ''.join(
        f'  - {{flag: after_{up}, upstream: {up}, downstream: {down}}}\n'
        for up, down in pairwise(inner)
    )
    text = f"""
sections:
  1:
    - {{id: place, @a1, qty_change: 1}}
{tasks}    - {{id: pack, @a1, qty_change: -1}}
lateral_dependencies:
  - {{flag: own, upstream: pack, downstream: place}}
{flags}"""
    stall = deadlock(Line(1).script(text))
    assert stall is not None
    assert [str(stand) for stand in stall.circle] == [
        'section 1 is waiting for pack to set flag own'
    ]


def test_8_2_the_shortest_of_several_circles_is_told() -> None:
    """Section 2 waits for section 3 in the same beat, and has no part in what keeps that."""
    text = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: t2, @a2}]
  3: [{id: early, @a3}, {id: late, @b3}]
  5: [{id: t5, @b5}, {id: pack, @a5, qty_change: -1}]
lateral_dependencies:
  - {flag: near, upstream: t2, downstream: late}
  - {flag: far, upstream: early, downstream: t5}
"""
    line = Line(5)
    script = line.script(text)
    assert run(line.cell, script, 10).waits['section 2'] == {'waiting for late to take flag near'}
    stall = deadlock(script)
    assert stall is not None
    assert [stand.part for stand in stall.circle] == ['section 3', 'section 5', 'belt']


@pytest.mark.parametrize(
    ('text', 'remedy'),
    [
        (flagged(2, 4), 'capacity 2 of flag coupled frees it'),
        (flagged(2, 3, initial=1), 'capacity 2 of flag coupled frees it'),
        (flagged(3, 2), 'initial count 1 of flag coupled frees it'),
        (flagged(4, 2), 'initial count 2 with capacity 2 of flag coupled frees it'),
    ],
)
def test_8_2_the_smallest_remedy_is_named_and_works(text: str, remedy: str) -> None:
    line = Line(5)
    script = line.script(text)
    stall = deadlock(script)
    assert stall is not None
    assert stall.remedy == remedy
    assert stall.flags == ('coupled',)
    assert run(line.cell, cured(script, stall), 10).finished


def test_8_2_swapped_ends_are_suggested_before_larger_count() -> None:
    line = Line(5)
    script = line.script(flagged(3, 2))
    stall = deadlock(script)
    assert stall is not None
    assert stall.hint == (
        'swap `upstream` and `downstream` of flag coupled; '
        'or initial count 1 of flag coupled frees it'
    )
    (flag,) = script.dependencies
    turned = replace(flag, upstream=flag.downstream, downstream=flag.upstream)
    assert run(line.cell, replace(script, dependencies=(turned,)), 10).finished


@pytest.mark.parametrize(
    'text',
    [
        flagged(2, 4),  # points forward
        flagged(4, 2),  # the other way round it gets stuck too
        flagged(4, 2, initial=1),  # counts are there for the first items
    ],
)
def test_8_2_other_ends_do_not_look_swapped(text: str) -> None:
    stall = deadlock(Line(5).script(text))
    assert stall is not None
    assert 'swap' not in stall.hint


def test_8_2_single_flag_cannot_free_two_flag_circle() -> None:
    text = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: late, @a2}, {id: early, @b2}]
  3: [{id: first, @a3}, {id: second, @b3}, {id: pack, @a3, qty_change: -1}]
lateral_dependencies:
  - {flag: one, upstream: second, downstream: late, initial: 0}
  - {flag: two, upstream: first, downstream: early, initial: 0}
"""
    stall = deadlock(Line(3).script(text))
    assert stall is not None
    assert stall.remedy == ''
    assert stall.hint == 'no larger capacity or initial count of one flag frees it'


PLACE = '{id: place, @a1, qty_change: 1}'
FREE = '{id: ahead, @b1, requires_conveyor: false}'


@pytest.mark.parametrize(
    ('lists', 'fine'),
    [
        (f'[{FREE}, {PLACE}]', False),
        (f'[{PLACE}, {{id: ahead, @b1}}]', False),
        (f'{{release_conveyor: after_last_conveyor_task, tasks: [{PLACE}, {FREE}]}}', True),
    ],
)
def test_8_2_released_belt_allows_waiting_for_next_item(lists: str, fine: bool) -> None:
    """The flag wants that an item has come to section 3 before the next one is begun."""
    text = f"""
sections:
  1: {lists}
  3: [{{id: pack, @a3, qty_change: -1}}]
lateral_dependencies:
  - {{flag: empty, upstream: ahead, downstream: pack}}
"""
    line = Line(3)
    script = line.script(text)
    assert (deadlock(script) is None) == fine
    assert run(line.cell, script, 6).finished == fine


DRAWN = 1
"""Seed of the gate: with it each kind of line is drawn often enough for the shares below."""


def test_8_2_graph_agrees_with_whole_runs_of_lines() -> None:
    """Verdict, item, beat and every wait of the circle, for even and for uneven durations."""
    seen: Counter[str] = Counter()

    @examples(25, 4000, drawn=DRAWN)
    @given(SEEDS)
    def holds(seed: int) -> None:
        drawn = FlaggedLine(seed)
        stall = deadlock(drawn.script)
        for quantity, durations in ((2, None), (3, seed)):
            full_run = run(drawn.line.cell, drawn.script, quantity * drawn.size, durations)
            assert full_run.finished == (stall is None), drawn.text
            if stall is not None:
                assert full_run.beat == stall.beat, drawn.text
                assert full_run.begun == min(stall.item, quantity * drawn.size), drawn.text
                for stand in stall.circle:
                    assert stand.wait.reason in full_run.waits[stand.part], drawn.text
        seen['all'] += 1
        seen['refused'] += stall is not None
        seen['with several parts'] += stall is not None and len(stall.circle) > 2

    holds()
    assert 0.2 * seen['all'] < seen['refused'] < 0.8 * seen['all'], seen
    assert seen['with several parts'] > 0.1 * seen['all'], seen


def test_8_2_job_as_long_as_line_shows_deadlock() -> None:
    """The bound of docs/deadlock_proof.md: sink - source items, and at least one."""
    seen: Counter[bool] = Counter()

    @examples(30, 2000)
    @given(SEEDS)
    def holds(seed: int) -> None:
        drawn = FlaggedLine(seed)
        items = max(1, drawn.sink - drawn.source)
        fine = deadlock(drawn.script) is None
        assert run(drawn.line.cell, drawn.script, items).finished == fine, drawn.text
        seen[fine] += 1

    holds()
    assert min(seen[True], seen[False]) > 0.2 * seen.total()


def test_8_2_only_full_remedy_frees_drawn_lines() -> None:
    seen: Counter[str] = Counter()

    @example(1199)
    @examples(30, 2000, drawn=DRAWN)
    @given(SEEDS)
    def holds(seed: int) -> None:
        drawn = FlaggedLine(seed, most_sections=5)
        stall = deadlock(drawn.script)
        if stall is None:
            return
        amount = drawn.size
        if stall.remedy:
            healed = cured(drawn.script, stall)
            assert run(drawn.line.cell, healed, 2 * drawn.size).finished, drawn.text
            (changed,) = set(healed.dependencies) - set(drawn.script.dependencies)
            before = next(d for d in drawn.script.dependencies if d.flag == changed.flag)
            amount = changed.initial - before.initial or changed.capacity - before.capacity
            amount -= 1
        for flag, more in product(drawn.script.dependencies, range(1, amount + 1)):
            for smaller in (
                replace(flag, capacity=flag.capacity + more),
                replace(
                    flag,
                    initial=flag.initial + more,
                    capacity=max(flag.capacity, flag.initial + more),
                ),
            ):
                changed_script = with_flag(drawn.script, smaller)
                assert not run(drawn.line.cell, changed_script, 2 * drawn.size).finished
        seen['freed' if stall.remedy else 'not freed'] += 1

    holds()
    assert seen['freed'] > 5, seen
    assert seen['not freed'] > 0, seen


def with_flag(script: Script, changed: Dependency) -> Script:
    flags = (changed if flag.flag == changed.flag else flag for flag in script.dependencies)
    return replace(script, dependencies=tuple(flags))


def cured(script: Script, knot: Deadlock) -> Script:
    """Return the script with the change that the remedy's words ask for."""
    flag = re.search(r'of flag (\w+)', knot.remedy)
    assert flag is not None
    before = next(dependency for dependency in script.dependencies if dependency.flag == flag[1])
    capacity = re.search(r'capacity (\d+)', knot.remedy)
    initial = re.search(r'initial count (\d+)', knot.remedy)
    changed = replace(
        before,
        capacity=int(capacity[1]) if capacity else before.capacity,
        initial=int(initial[1]) if initial else before.initial,
    )
    assert changed != before
    return with_flag(script, changed)


# --- several scripts ------------------------------------------------------------------------


def test_8_2_scripts_without_common_flags_cannot_get_stuck_together() -> None:
    line = Line(5)
    script = line.script(flagged(2, 3))
    other = line.script(flagged(3, 4).replace('coupled', 'other'))
    assert not get_stuck_together([script, other])


def test_8_2_graph_predicts_deadlock_of_flag_sharing_scripts(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Items of both follow each other in many orders; the queue would refuse the later script."""
    monkeypatch.setattr('bt_orchestrator.model.proof.sharing.get_stuck_together', lambda _: False)
    seen: Counter[bool] = Counter()

    @example(211)
    @example(867)
    @example(1741)
    @examples(8, 4000)
    @given(SEEDS)
    def holds(seed: int) -> None:
        drawn, order = SharingScripts(seed), random.Random(seed)
        alone = [script for script in drawn.scripts if deadlock(script) is None]
        if len(alone) < 2:
            return
        stuck = get_stuck_together(alone)
        mixes = (order.choices(alone, k=2 * drawn.size) for _ in range(40 if stuck else 3))
        assert stuck == any(gets_stuck(drawn.line.cell, mix) for mix in mixes)
        seen[stuck] += 1

    holds()
    assert min(seen[True], seen[False]) >= 3, seen


def gets_stuck(cell: Cell, mix: Sequence[Script]) -> bool:
    """Tell whether a run of jobs of one item each comes to a standstill."""
    simulation = Simulation(cell, TYPES, MemoryStore())
    answers = simulation.submit(
        Job(f'J{n}', script, 1, defaults(script)) for n, script in enumerate(mix)
    )
    assert all(answer.accepted for answer in answers)
    outcome = simulation.run()
    simulation.close()
    return outcome is Outcome.STUCK


# --- long lines -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ('upstream', 'downstream', 'remedy'),
    [
        ('t50_5', 't51_6', None),
        ('t1_5', 't200_6', 'capacity 199 of flag far frees it'),
        ('t200_5', 't1_6', 'initial count 199 with capacity 199 of flag far frees it'),
    ],
)
def test_8_2_a_line_of_200_sections_and_2000_tasks(
    upstream: str, downstream: str, remedy: str | None
) -> None:
    """A flag between any two neighbours, and one more."""
    lines = ['sections:']
    for n in range(1, 201):
        tasks = [f'{{id: t{n}_{k}, @{"ab"[k % 2]}{n}}}' for k in range(10)]
        lines.append(f'  {n}: [{", ".join(tasks)}]')
    lines[1] = lines[1].replace('@a1', '@a1, qty_change: 1', 1)
    lines[200] = lines[200].replace('t200_9, @b200', 't200_9, @b200, qty_change: -1')
    lines.append('lateral_dependencies:')
    lines += [
        f'  - {{flag: f{n}, upstream: t{n}_0, downstream: t{n + 1}_0}}' for n in range(1, 200)
    ]
    lines.append(f'  - {{flag: far, upstream: {upstream}, downstream: {downstream}}}')
    stall = deadlock(line_of(200).script('\n'.join(lines)))
    assert (stall and stall.remedy) == remedy
