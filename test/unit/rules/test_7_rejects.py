"""Semantics 7.7: runs of rejects hold the line."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from fakes.commands import Pause, Reset, Resume, Start, Stop
from fakes.line import Line, with_section
from fakes.virtual_run import VirtualRun
from fakes.world import World, begun

from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import HoldAfter
from bt_orchestrator.model.hold_words import hold_words
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.sim.simulation import Outcome, Simulation
from bt_orchestrator.sim.standing_answers import StandingAnswers
from bt_orchestrator.store.memory import MemoryStore

OUT = 'qty_change: -1, runs_for: all'
INSPECT = '- {id: inspect, @a2, on_failure: reject}'
SORTED = with_section(2, INSPECT).replace('qty_change: -1', OUT)
CHECKED = SORTED.replace('[{id: pack', '[{id: check, @b3, on_failure: reject}, {id: pack')
JUDGED = with_section(
    2,
    """
    - id: weigh
      task: TASK_A
      action: /a2/do
      on_failure: reject
      fails_unless: {value: "${results.weigh.measurement}", at_most: "${params.most}"}
    """,
).replace('qty_change: -1', OUT)
OF_ITS_OWN = 'hold_after: {rejects: 2, of: 2}\n'
PARAMS = (
    'params: {most: {type: float, default: 1.5}, glue: {type: str, default: G7}}\n'
    'lots: {glue: "${params.glue}"}\n'
)


def bad(*goals: int) -> str:
    """Return the faults of a component whose goals of these numbers fail."""
    return ' '.join(f'#{n}=abort' for n in goals)


def limited(rejects: int, of: int, *, seconds: Any = None, **faults: str) -> Line:
    """Return a line that is held after so many rejects of so many items."""
    line = Line(seconds=seconds, faults=faults)
    line.cell = replace(line.cell, hold_after=HoldAfter(rejects, of))
    return line


def raised(run: VirtualRun) -> list[dict[str, Any]]:
    return run.all('hold.raised', reason='too_many_rejects')


def items(run: VirtualRun) -> list[list[str]]:
    return [hold['items'] for hold in raised(run)]


def released(run: VirtualRun) -> VirtualRun:
    (hold,) = run.state.holds
    assert run.command(Resume, hold=hold).accepted
    return run.go()


def test_7_7_third_reject_of_ten_holds_line() -> None:
    run = limited(3, 10, a2=bad(1, 4, 6)).run(SORTED, 9)
    assert items(run) == [['J/1', 'J/4', 'J/6']]
    assert run.times('hold.raised') == run.times('item.rejected', item='J/6')
    assert run.state.packml.value == 'Held'
    released(run)
    assert run.ended
    assert run.counts()['rejected'] == 3


def test_7_7_rejects_that_are_further_apart_are_no_run() -> None:
    run = limited(3, 4, a2=bad(1, 3, 5, 7)).run(SORTED, 9)
    assert run.ended
    assert not raised(run)


@pytest.mark.parametrize(('of', 'number'), [(5, 1), (4, 0)])
def test_7_7_window_counts_first_and_last_item(of: int, number: int) -> None:
    run = limited(3, of, a2=bad(2, 3, 6)).run(SORTED, 7)
    assert len(raised(run)) == number


def test_7_7_leaving_good_items_do_not_break_sequence() -> None:
    """Items 1 and 2 leave the line while 3 and 4 are rejected: the order of the belt counts."""
    line = limited(2, 2, seconds={'a3': 1.5}, a2=bad(3, 4))
    run = line.run(SORTED, 6)
    assert items(run) == [['J/3', 'J/4']]
    left = run.times('item.removed', item='J/2')
    assert run.times('item.rejected', item='J/3') < left < run.times('item.rejected', item='J/4')


def test_7_7_rejects_of_two_sections_count_in_line_order() -> None:
    run = limited(2, 2, seconds={'b3': 3.0}, a2=bad(2), b3=bad(1)).run(CHECKED, 4)
    assert run.times('item.rejected', item='J/2') < run.times('item.rejected', item='J/1')
    assert items(run) == [['J/1', 'J/2']]
    assert 'by the tasks check, inspect' in raised(run)[0]['message']


def test_7_7_cycles_in_hand_end_and_nothing_begins() -> None:
    run = limited(1, 1, a2=bad(2)).run(
        with_section(2, f'{INSPECT}\n- {{id: mark, @b2, runs_for: all}}').replace(
            'qty_change: -1', OUT
        ),
        5,
    )
    held = run.times('hold.raised')[0]
    assert run.starts('mark', item='J/2') == [held], 'the same section goes on'
    assert [moment for moment in run.times('cycle.started') if moment > held] == []
    assert [moment for moment in run.times('belt.index_started') if moment > held] == []
    assert run.times('cycle.completed', item='J/2', section=2)
    assert run.state.packml.value == 'Held'


def test_7_7_initialization_of_the_next_job_does_not_begin() -> None:
    line = limited(1, 1, a2=bad(1))
    run = line.begin(SORTED)
    run.submit(
        'K',
        line.script(f'initialization: [{{id: home, task: PREPARE, action: /a2/do}}]\n{SORTED}'),
    )
    run.go()
    assert raised(run)
    assert not run.starts('home')
    released(run)
    assert run.starts('home')


def test_7_7_only_its_number_releases_it() -> None:
    run = limited(1, 1, a2=bad(1)).run(SORTED, 2)
    (hold,) = run.state.holds.values()
    assert hold.answers == ('resume',)
    for everyones in (False, True):
        answer = run.command(Resume, everyones=everyones)
        assert 'which only its number releases: bt-orchestrator cell resume --hold 1' in (
            answer.message
        )
    assert 'takes no answer' in run.answer('retry').message
    released(run)
    assert run.ended


def test_7_7_a_pause_beside_it_is_released_by_itself() -> None:
    run = limited(1, 1, a2=bad(1)).run(SORTED, 2)
    assert run.command(Pause).accepted
    assert run.command(Resume).accepted
    assert list(run.state.holds) == ['1']


def test_7_7_release_also_forgets_rejects_during_hold() -> None:
    run = limited(2, 5, a2=bad(2, 3, 5), b3=bad(1)).run(CHECKED, 8)
    assert items(run) == [['J/1', 'J/2']]
    released(run)
    assert items(run)[1] == ['J/3', 'J/5']


def test_7_7_a_reject_counts_once() -> None:
    """A task for rejected items that rejects again adds nothing, also after the release."""
    again = ', {id: again, @b3, runs_for: rejected, on_failure: reject}'
    text = SORTED.replace('[{id: pack', f'[{again[2:]}, {{id: pack')
    run = limited(1, 1, a2=bad(1), b3=bad(1)).run(text, 2)
    released(run)
    assert run.ended
    assert run.all('task.continued', task='again', policy='reject')
    assert len(raised(run)) == 1


def test_7_7_items_of_aborted_job_are_no_rejects() -> None:
    again = '{id: again, @b3, runs_for: rejected, on_failure: reject}'
    text = SORTED.replace('[{id: pack', f'[{again}, {{id: pack')
    run = limited(1, 3, b3=bad(1)).begin(text, 5).go(until=8.0)
    run.control('abort', 'J')
    run.go()
    assert run.ended
    assert run.all('task.continued', task='again', policy='reject')
    assert len(run.all('item.rejected')) >= 2
    assert not raised(run)


def test_7_7_the_answer_reject_makes_a_reject() -> None:
    run = limited(1, 3, a2=bad(2)).run(SORTED.replace('on_failure: reject', 'retries: 0'), 3)
    run.answer('reject')
    assert items(run) == [['J/2']]


def test_7_7_nonconforming_and_removed_items_are_no_rejects() -> None:
    run = limited(1, 9, a2=bad(1, 2)).begin(SORTED.replace('reject', 'continue'), 4)
    run.go(until=9.0)
    assert run.remove('J/3').accepted
    run.go()
    assert run.ended
    assert run.counts()['nonconforming'] == 2
    assert not raised(run)


def test_7_7_items_of_all_jobs_are_counted_together() -> None:
    line = limited(3, 3, a2=bad(1, 2, 3))
    run = line.begin(SORTED)
    for name in 'KLM':
        run.submit(name, line.script(SORTED))
    run.go()
    assert items(run) == [['J/1', 'K/1', 'L/1']]
    assert 'all of product test' in raised(run)[0]['message']
    assert 'all of job' not in raised(run)[0]['message']


def test_7_7_script_with_own_limit_counts_separately() -> None:
    """Its items are none of the cell's, and take its limit in place of the cell's."""
    line = limited(3, 9, a2=bad(1, 2, 3, 4, 5))
    own, other = line.script(OF_ITS_OWN + SORTED, 'own'), line.script(SORTED, 'other')
    run = line.begin(SORTED)
    for name, script in (('K', own), ('L', other), ('M', own), ('N', other)):
        run.submit(name, script)
    run.go()
    assert items(run) == [['K/1', 'M/1']]
    released(run)
    assert items(run)[1:] == [['J/1', 'L/1', 'N/1']]
    released(run)
    assert run.ended


def test_7_7_each_count_raises_one_hold_at_a_time() -> None:
    line = limited(1, 1, a2=bad(1), b3=bad(1, 2))
    run = line.begin(CHECKED, 1)
    run.submit('K', line.script(f'hold_after: {{rejects: 1, of: 1}}\n{CHECKED}', 'own'))
    run.go()
    assert items(run) == [['J/1']]
    released(run)
    assert items(run) == [['J/1'], ['K/1']]


def test_7_7_stop_and_start_keep_reject_count() -> None:
    run = limited(2, 2, a2=bad(1, 2)).begin(SORTED, 4).go(until=6.0)
    assert run.all('item.rejected')
    run.command(Stop)
    run.go(until=20.0)
    assert run.state.packml.value == 'Stopped'
    for command in (Reset, Start):
        run.command(command)
    run.go()
    assert items(run) == [['J/1', 'J/2']]


def test_7_7_a_hold_for_rejects_leaves_setups_known() -> None:
    gripper = (
        'setups: {gripper: [small, large]}, '
        'changes: {gripper: {task: TASK_C, argument: special_argument_1}}'
    )
    line = Line(keys={'b2': gripper}, faults={'a2': bad(1)})
    line.cell = replace(line.cell, hold_after=HoldAfter(1, 1))
    two = f'{INSPECT}\n- {{id: use, @b2, setup: {{gripper: small}}}}'
    run = line.run(with_section(2, two).replace('qty_change: -1', OUT), 2)
    assert raised(run)
    assert released(run).ended
    assert 'setup_missing' not in run.reasons()


def test_7_7_hold_shows_common_traits_of_rejects() -> None:
    line = Line(results={'a2': {'measurement': 2.5}})
    line.cell = replace(line.cell, hold_after=HoldAfter(2, 5))
    run = line.run(PARAMS + JUDGED, 3, most=1.5, glue='G7')
    (hold,) = run.state.holds.values()
    assert hold_words(hold) == (
        'J: too_many_rejects (2 rejects within 5 items: J/1, J/2; all by task weigh; '
        'all at a2; all for the reason result_refused; all of product test; all of job J; '
        'all with lot G7 of glue; each time expected: ${results.weigh.measurement} at most 1.5)'
    )
    assert [word.kind for word in hold.message_words] == [
        'rejects',
        *(f'rejects_{word}' for word in ('task', 'component', 'reason', 'product', 'job', 'lot')),
        'rejects_verdict',
    ]


def test_7_7_killed_after_any_settle_the_count_goes_on() -> None:
    line = limited(3, 4, a2=bad(1, 3, 4))
    kills = 0
    for settles in range(1, 200):
        world = World(line.cell)
        first = begun(world, line.script(SORTED), 5)
        world.go(first, settles)
        over = bool(first.state.holds)
        first.close()
        second = world.orchestrator()
        world.go(second)
        held = [event for event in world.store.read() if isinstance(event, e.HoldRaised)]
        assert [event.items for event in held if event.items] == [('J/1', 'J/3', 'J/4')], settles
        second.close()
        kills += 1
        if over:
            break
    assert kills > 10


def test_7_7_what_waits_names_the_hold_in_short() -> None:
    run = limited(1, 1, a2=bad(1)).run(SORTED, 2)
    assert run.waits()['belt'] == 'waiting for an answer to hold 1 (J: too_many_rejects)'


def test_7_7_a_simulated_operator_resumes() -> None:
    line = limited(2, 2, a2=bad(1, 2, 3, 4))
    simulation = Simulation(line.cell, line.types, MemoryStore())
    operator = StandingAnswers(simulation, ('resume',), 60.0, 'the shift')
    simulation.submit([Job('J', line.script(SORTED), 4, {})])
    assert simulation.run(operator.look) is Outcome.FINISHED
    assert operator.complaints() == []
    assert simulation.state.time > 2 * 60.0
