"""Semantics 4: flags, zones, aborting a job."""

from __future__ import annotations

from typing import Any

import pytest
from fakes.commands import Abort
from fakes.line import THREE, Line, with_section
from fakes.virtual_run import VirtualRun

CAMERA = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: look, @a2}, {id: other, @b2}]
  3: [{id: use, @a3}, {id: pack, @b3, qty_change: -1, runs_for: all}]
lateral_dependencies:
  - {flag: clear, upstream: use, downstream: look, initial: 1}
"""
"""Section 2 may look at an item only when section 3 has used what it saw of the one before."""


def flag_counts(run: VirtualRun) -> list[tuple[float, str, int]]:
    """Return every change of a flag: when, by which task, to which count."""
    return [
        (record['time'], record['task'], record['count'])
        for record in run.records
        if record['event'] in ('flag.raised', 'flag.lowered')
    ]


# --- 4.1 ------------------------------------------------------------------------------------


def test_4_1_downstream_task_waits_for_flag_and_takes_it() -> None:
    run = Line(seconds={'a3': 2.5}).run(CAMERA, 3)
    assert run.starts('look') == [3.0, 9.5, 16.0]
    assert flag_counts(run)[:3] == [(4.0, 'look', 0), (9.5, 'use', 1), (10.5, 'look', 0)]


def test_4_1_upstream_task_waits_while_counter_is_full() -> None:
    text = """
    sections:
      1: [{id: pick, @a1, requires_conveyor: false}, {id: place, @b1, qty_change: 1}]
      3: [{id: pack, @a3, qty_change: -1}]
    lateral_dependencies:
      - {flag: part, upstream: pick, downstream: pack, capacity: 2}
    """
    run = Line().begin(text, 4).go(until=5.0)
    assert run.starts('pick') == [0.0, 2.0]
    assert run.waits()['section 1'] == 'waiting for pack to take flag part'
    run.go()
    # Taken by the end of `pack`, when the item has passed both moves.
    assert run.starts('pick')[2] == run.times('flag.lowered')[0] == 8.0
    assert run.ended


def test_4_1_the_reason_names_flag_and_task() -> None:
    run = Line(seconds={'a3': 2.5}).begin(CAMERA, 2).go(until=8.0)
    assert run.waits()['section 2'] == 'waiting for use to set flag clear'


def test_4_1_the_flag_changes_when_the_task_has_executed() -> None:
    run = Line().run(CAMERA)
    assert run.times('flag.lowered', task='look') == run.times('task.succeeded', task='look')
    assert run.times('flag.raised', task='use') == run.times('task.succeeded', task='use')


def test_4_1_a_failed_attempt_does_not_touch_the_flag() -> None:
    text = CAMERA.replace('id: look, @a2', 'id: look, @a2, retries: 1')
    run = Line(faults={'a2': '#1=abort'}).run(text)
    assert run.times('flag.lowered') == [5.0]


def test_4_1_running_task_does_not_recheck_its_flag() -> None:
    """The flag is at 0 when `look` has taken it, and its own cycle goes on all the same."""
    run = Line().run(CAMERA)
    assert run.starts('other') == [4.0]


def test_4_1_scripts_that_share_a_flag_have_to_agree() -> None:
    line = Line()
    run = line.begin(CAMERA, 2)
    others = {
        'capacity': CAMERA.replace('initial: 1', 'initial: 1, capacity: 2'),
        'initial': CAMERA.replace('initial: 1', 'initial: 0'),
        'sections': CAMERA.replace('downstream: look', 'downstream: place'),
    }
    for text in others.values():
        answer = run.submit('K', line.script(text, 'other'))
        assert not answer.accepted
        assert 'share the flag clear' in answer.message
    assert run.submit('K', line.script(CAMERA, 'other')).accepted
    run.go()
    assert run.ended


COMMON = """
lateral_dependencies:
  - {flag: near, upstream: fill, downstream: turn, capacity: 2}
  - {flag: far, upstream: lift, downstream: lower}
"""
IN_TURN = f"""
sections:
  1: [{{id: place, @a1, qty_change: 1}}]
  2: [{{id: fill, @a2}}]
  4:
    release_conveyor: after_last_conveyor_task
    tasks:
      - {{id: clamp, @a4}}
      - {{id: turn, @a4, requires_conveyor: false}}
      - {{id: lift, @b4, requires_conveyor: false}}
  6: [{{id: lower, @a6}}, {{id: pack, @b6, qty_change: -1}}]
{COMMON}"""
AHEAD = f"""
sections:
  1: [{{id: place, @a1, qty_change: 1}}]
  2:
    release_conveyor: after_last_conveyor_task
    tasks: [{{id: look, @a2}}, {{id: fill, @a2, requires_conveyor: false}}]
  4:
    release_conveyor: after_last_conveyor_task
    tasks:
      - {{id: clamp, @a4}}
      - {{id: lift, @b4, requires_conveyor: false}}
      - {{id: turn, @a4, requires_conveyor: false}}
  6: [{{id: lower, @a6}}, {{id: pack, @b6, qty_change: -1}}]
{COMMON}"""
"""Neither gets stuck alone. In a mix of them `fill` of item 4 waits for `turn` of item 2, that for
`lift`, that for `lower` of item 1, and that for the belt, which waits for `fill` of item 4."""


def mixed(line: Line) -> VirtualRun:
    run = line.begin(IN_TURN, 1)
    run.submit('K', line.script(AHEAD, 'ahead'), 2)
    run.submit('L', line.script(IN_TURN), 3)
    return run.go()


def test_4_1_scripts_with_deadlocking_flags_are_not_mixed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    line = Line(6)
    assert line.run(IN_TURN, 12).ended
    assert line.run(AHEAD, 12).ended

    run = mixed(line)
    assert run.ended
    assert 'K' not in run.state.order_ids
    answer = line.begin(IN_TURN).submit('K', line.script(AHEAD, 'ahead'))
    assert 'script ahead shares flags with test, and where jobs of both' in answer.message

    monkeypatch.setattr('bt_orchestrator.model.proof.sharing.get_stuck_together', lambda _: False)
    run = mixed(line)
    assert not run.ended
    assert run.waits()['section 2'] == 'waiting for turn to take flag near'


def test_4_1_unused_flag_is_created_anew() -> None:
    line = Line()
    run = line.run(CAMERA)
    other = CAMERA.replace(
        'upstream: use, downstream: look, initial: 1',
        'upstream: look, downstream: use, capacity: 2',
    )
    assert run.submit('K', line.script(other, 'other'), 2).accepted
    assert run.state.flags['clear'].count == 0
    assert run.state.flags['clear'].capacity == 2
    run.go()
    assert run.ended


# --- 4.2 ------------------------------------------------------------------------------------


def test_4_2_skipped_task_waits_for_flag_and_takes_it() -> None:
    text = CAMERA.replace(
        'id: look, @a2', 'id: look, @a2, when: {value: "${item.number}", equals: 1}'
    )
    run = Line(seconds={'a3': 2.5}).run(text, 2)
    assert run.starts('look') == [3.0]
    assert run.times('task.skipped', task='look', item='J/2') == [9.5]
    assert flag_counts(run) == [
        (4.0, 'look', 0),
        (9.5, 'use', 1),
        (9.5, 'look', 0),
        (15.0, 'use', 1),
    ]


def test_4_2_continued_failure_performs_flag_operations() -> None:
    text = CAMERA.replace('id: use, @a3', 'id: use, @a3, on_failure: continue')
    run = Line(faults={'a3': '#1=abort'}).run(text, 2)
    assert run.times('flag.raised', item='J/1') == run.times('task.continued', item='J/1')
    assert run.ended


def test_4_2_rejected_item_carries_flags_through_line() -> None:
    text = CAMERA.replace('id: other, @b2', 'id: other, @b2, on_failure: reject')
    run = Line(faults={'b2': '#1=abort'}).run(text, 3)
    assert run.times('task.skipped', task='use', item='J/1') != []
    assert len(run.all('flag.raised')) == len(run.all('flag.lowered')) == 3
    assert run.ended


def test_4_2_empty_position_carries_flags_through_line() -> None:
    text = CAMERA.replace('qty_change: 1}', 'qty_change: 1, on_failure: continue}')
    run = Line(faults={'a1': '#2=abort'}).run(text, 3)
    assert run.order('item.missing', 'item') == ['J/2']
    assert len(run.all('flag.raised')) == len(run.all('flag.lowered')) == 3
    assert run.state.flags['clear'].count == 1


def test_4_2_an_operators_skip_performs_the_flag_operations() -> None:
    run = Line(faults={'a3': '#1=abort'}).run(CAMERA, 2)
    run.answer('skip')
    assert run.times('flag.raised', task='use') == [8.0]
    run.go()
    assert run.ended


def test_4_2_skipped_task_needs_no_component_zone_or_readiness() -> None:
    text = """
    sections:
      1: [{id: place, @a1, qty_change: 1}]
      2: [{id: never, @a2, when: {value: "${item.number}", equals: 0}}]
      3: [{id: pack, @a3, qty_change: -1}]
    """
    run = Line(topics=('a2',), faults={'a2': '#0=silent'}).run(text)
    assert run.times('task.skipped', task='never') == [3.0]
    assert run.ended


# --- 4.3 ------------------------------------------------------------------------------------


def test_4_3_abort_job_drains_the_line() -> None:
    text = CAMERA.replace('id: other, @b2', 'id: other, @b2, on_failure: abort_job')
    run = Line(faults={'b2': '#2=abort'}, seconds={'a1': 5.0}).run(text, 9)
    (at,) = run.times('job.aborting')
    assert [hold.task for hold in run.state.holds.values()] == ['place']
    run.answer('skip')
    run.go()
    assert [r for r in run.all('cycle.started', section=1) if r['time'] > at] == []
    assert run.times('job.aborted') != []
    assert run.state.flags['clear'].count == 1
    assert len(run.all('flag.raised')) == len(run.all('flag.lowered'))


def test_4_3_aborted_source_cycle_leaves_empty_position() -> None:
    text = """
    sections:
      1: [{id: pick, @a1, requires_conveyor: false}, {id: place, @b1, qty_change: 1}]
      2: [{id: work, @a2, on_failure: abort_job}]
      3: [{id: pack, @a3, qty_change: -1, runs_for: all}]
    """
    run = Line(faults={'a2': '#1=abort'}, seconds={'a1': 3.5}).run(text, 9)
    # Item 2 is being picked from 4.5 to 8.0 when `work` fails at 7.5.
    assert run.times('task.cancel_requested', task='pick', cause='abort_job') == [7.5]
    assert run.times('task.continued', task='pick', item='J/2') == [7.5]
    assert run.times('item.missing', item='J/2') == [7.5]
    assert run.ended
    assert run.counts() == {'started': 2, 'placed': 1, 'rejected': 1, 'missing': 1}


def cut_off(task: str, fault: str = '#9=abort') -> VirtualRun:
    """Abort a job while one of its tasks is about to place an item, or to take one out."""
    text = THREE.replace('qty_change: -1', 'qty_change: -1, runs_for: all')
    component = {'place': 'a1', 'pack': 'a3'}[task]
    run = Line(seconds={component: 4.0}, faults={component: fault}).begin(text)
    run.go(until={'place': 0.0, 'pack': 6.0}[task])
    assert [key.task for key in run.state.running] == [task]
    assert run.control('abort', 'J').accepted
    return run.go()


@pytest.mark.parametrize('fault', ['#9=abort', '#1=ignore_cancel'])
@pytest.mark.parametrize(
    ('task', 'asked'), [('place', 'placed in section 1'), ('pack', 'taken out of section 3')]
)
def test_4_3_belt_waits_for_answer_about_slot(task: str, asked: str, fault: str) -> None:
    run = cut_off(task, fault)
    moves = run.times('belt.index_started')
    (hold,) = run.state.holds.values()
    assert (hold.task, hold.answers) == (task, ('mark_done', 'skip'))
    assert hold.message.endswith(f'was J/1 {asked}? mark_done if it was, else skip')
    assert run.state.packml.value == 'Held'
    assert not any(run.answer(word).accepted for word in ('retry', 'reject', 'abort_job'))
    assert run.times('belt.index_started') == moves


def test_4_3_placing_without_server_raises_no_hold() -> None:
    run = cut_off('place', '=absent')
    assert run.times('hold.raised') == []
    assert run.ended
    assert run.counts() == {'started': 1, 'missing': 1}


def test_4_3_hold_after_abort_reports_unsent_goal() -> None:
    run = Line(faults={'a1': '=absent'}).begin(THREE).go(until=1.0)
    assert run.command(Abort).accepted
    run.go()
    (hold,) = run.state.holds.values()
    assert hold.message == 'withdrawn before it was sent'
    assert 'reject' in hold.answers


def test_4_3_an_item_that_was_placed_after_all_drains() -> None:
    run = cut_off('place')
    run.answer('mark_done')
    run.go()
    assert run.ended
    assert run.counts() == {'started': 1, 'placed': 1, 'rejected': 1}


def test_4_3_unplaced_item_leaves_empty_position() -> None:
    run = cut_off('place')
    run.answer('skip')
    run.go()
    assert run.ended
    assert run.counts() == {'started': 1, 'missing': 1}


def test_4_3_mark_done_confirms_item_as_taken_out() -> None:
    run = cut_off('pack')
    run.answer('mark_done')
    run.go()
    assert run.ended
    assert run.counts()['rejected'] == 1


def test_4_3_twin_skips_item_confirmed_as_taken_out() -> None:
    twins = (
        '- {id: pack, @a3, qty_change: -1}\n'
        '- {id: unpack, @a3, qty_change: -1, runs_for: rejected}\n'
    )
    run = Line(seconds={'a3': 4.0}).begin(with_section(3, twins))
    run.go(until=6.0)
    assert [key.task for key in run.state.running] == ['pack']
    assert run.control('abort', 'J').accepted
    run.go().answer('mark_done')
    run.go()
    assert run.ended
    assert run.starts('unpack') == []
    assert run.all('task.skipped', task='unpack', reason='it was taken out before')


def test_4_3_item_not_taken_out_stays_in_slot() -> None:
    run = cut_off('pack')
    run.answer('skip')
    run.go()
    assert run.state.sections[3].slot == 'J/1'
    assert [hold.reason for hold in run.state.holds.values()] == ['overrun']  # 3.6
    run.remove('J/1')
    run.go()
    assert run.ended
    assert run.counts()['removed'] == 1


def test_4_3_a_cancel_that_is_ignored_holds_in_doubt() -> None:
    text = THREE.replace('id: work, @a2', 'id: work, @a2, on_failure: abort_job').replace(
        'qty_change: -1', 'qty_change: -1, runs_for: all'
    )
    line = Line(faults={'a2': '#1=abort', 'a1': '#2=ignore_cancel'})
    run = line.run(text, 9)
    assert run.times('task.cancel_requested', task='place', cause='abort_job') == [4.0]
    assert run.times('hold.raised', task='place', reason='in_doubt') == [9.0]
    run.answer('mark_done')
    run.go()
    assert run.ended
    assert run.counts() == {'started': 2, 'placed': 2, 'rejected': 2}


def test_4_3_abort_job_leaves_waiting_job_alone() -> None:
    text = THREE.replace('id: work, @a2', 'id: work, @a2, on_failure: abort_job').replace(
        'qty_change: -1', 'qty_change: -1, runs_for: all'
    )
    line = Line(faults={'a2': '#1=abort'})
    run = line.begin(text, 5)
    run.submit('K', line.script(text), 2)
    run.go()
    assert run.order('job.aborted', 'job') == ['J']
    assert run.counts('K')['packed'] == 2


# --- 4.4 ------------------------------------------------------------------------------------

TABLE = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: two, @a2}]
  3: [{id: three, @a3}, {id: pack, @b3, qty_change: -1}]
zones:
  table: [two, three]
"""


def test_4_4_tasks_of_a_zone_never_overlap() -> None:
    run = Line(seconds={'a3': 4.0}).run(TABLE, 2)
    assert run.starts('three', item='J/1') == [6.0]
    assert run.starts('two', item='J/2') == [10.0]


def test_4_4_the_reason_names_zone_and_task() -> None:
    run = Line(seconds={'a3': 4.0}).begin(TABLE, 2).go(until=6.0)
    assert run.waits()['section 2'] == 'waiting for zone table, taken by three of J/1'


def held_on_the_table(more: str = '', fault: str = '#1=abort', **given: Any) -> VirtualRun:
    """Let `three` fail in the zone of `two`, and go on to where the cell is Held."""
    text = TABLE.replace('@a3', f'@a3{more}').replace('@b3', '@b3, runs_for: all')
    return Line(faults={'a3': fault}, **given).run(text, 2)


@pytest.mark.parametrize('fault', ['#1=abort', '#1=reject', '#0=absent', '#1=hang', '#1=die:1'])
def test_4_4_a_held_task_keeps_its_zone(fault: str) -> None:
    run = held_on_the_table(fault=fault)
    assert run.state.packml.value == 'Held'
    assert run.starts('two', item='J/2') == []
    assert run.waits()['section 2'] == (
        'waiting for zone table, taken by three of J/1, which waits for an answer to hold 1'
    )


@pytest.mark.parametrize('answer', ['mark_done', 'skip', 'reject', 'abort_job'])
def test_4_4_answer_that_ends_task_frees_zone(answer: str) -> None:
    run = held_on_the_table()
    at = run.now
    run.answer(answer)
    waits = answer == 'abort_job'  # item 2 is rejected, and not worked on any more
    assert run.starts('two', item='J/2') == ([] if waits else [at])
    assert not run.state.holds
    assert set(run.state.zones.values()) <= set(run.state.running)


@pytest.mark.parametrize('policy', ['continue', 'reject', 'abort_job'])
def test_4_4_continuing_policy_frees_zone_at_once(policy: str) -> None:
    run = held_on_the_table(f', on_failure: {policy}')
    assert run.times('task.continued', task='three') == [7.0]
    assert run.starts('two', item='J/2') == ([] if policy == 'abort_job' else [7.0])


def test_4_4_task_leaves_zone_between_own_retries() -> None:
    run = held_on_the_table(', retries: 1, retry_delay: 0.5')
    assert run.starts('two', item='J/2') == [7.0]
    assert run.starts('three', item='J/1') == [6.0, 8.0]


def test_4_4_held_task_keeps_zone_after_last_retry() -> None:
    run = held_on_the_table(', retries: 1', '#1=abort #2=abort', seconds={'a2': 0.25})
    assert run.starts('two', item='J/2') == [7.0]
    assert run.state.zones['table'].task == 'three'


def test_4_4_answered_task_keeps_zone_until_new_attempt() -> None:
    text = TABLE.replace('{id: three', '{id: look, @b3}, {id: three')
    run = Line(faults={'a2': '#2=abort'}).run(text, 2)
    # Downstream goes first, but `two` stands where it failed.
    assert run.starts('three') == []
    run.pause()
    run.answer('retry', hold='1')
    assert run.waits()['section 3'] == (
        'waiting for zone table, taken by two of J/2, which is to be tried again'
    )
    run.resume()
    assert run.starts('two', item='J/2') == [6.0, run.now]
    run.go()
    assert run.starts('three', item='J/1') == run.times('task.succeeded', task='two', item='J/2')
    assert run.ended


def test_4_4_answer_frees_zone_of_removed_item() -> None:
    run = held_on_the_table()
    run.remove('J/1')
    assert run.starts('two', item='J/2') == []  # the robot still stands there
    run.answer('mark_done')
    assert run.starts('two', item='J/2') == [run.now]
    run.go()
    assert run.ended


def test_4_4_a_retry_that_is_skipped_frees_the_zone() -> None:
    text = TABLE.replace('{id: three, @a3}', 'parallel: [{id: three, @a3}, {id: bad, @b3}]')
    text = text.replace('id: pack, @b3', 'id: pack, @b3, runs_for: all')
    line = Line(faults={'a3': '#1=abort', 'b3': '#1=abort'})
    run = line.run(text, 2)
    assert [hold.task for hold in run.state.holds.values()] == ['three', 'bad']
    run.answer('retry', hold='1')
    assert run.state.zones['table'].task == 'three'  # it waits for the answer to `bad`
    run.answer('reject', hold='2')
    assert run.all('task.skipped', task='three', item='J/1') != []
    assert run.starts('two', item='J/2') == [run.now]
    run.go()
    assert run.ended


def test_4_4_a_held_initialization_task_keeps_its_zone() -> None:
    text = """
    initialization: [{id: light, @lamp}, {id: ready, @a2}]
    sections:
      1: [{id: place, @a1, qty_change: 1}]
      2: [{id: work, @a2}]
      3: [{id: pack, @a3, qty_change: -1}]
    zones: {table: [light, ready]}
    """
    run = Line(faults={'lamp': '#1=abort'}).run(text, 1)
    assert run.starts('ready') == []
    assert run.state.zones['table'].task == 'light'
    run.answer('skip')
    run.go()
    assert run.ended


def test_4_4_nothing_is_held_while_waiting() -> None:
    """`two` waits for its component and has not entered the zone, which `three` needs."""
    line = Line(topics=('a2',), faults={'a2': '#1=not_ready:30'})
    run = line.run(TABLE, 2)
    assert run.starts('three', item='J/1') == [6.0]
    assert run.starts('two', item='J/2') == [34.0]


def test_4_4_the_downstream_section_goes_first() -> None:
    text = """
    sections:
      1: [{id: place, @a1, qty_change: 1}]
      2: [{id: two, @arm}]
      3: [{id: three, @arm}, {id: pack, @b3, qty_change: -1}]
    """
    run = Line().run(text, 3)
    assert run.starts('three', item='J/1') == [6.0]
    assert run.starts('two', item='J/2') == [7.0]


def test_4_4_initialization_goes_before_sections() -> None:
    text = """
    initialization: [{id: light, @lamp}]
    sections:
      1: [{id: place, @a1, qty_change: 1}]
      2: [{id: work, @a2}]
      3: [{id: pack, @a3, qty_change: -1}]
    """
    second = text.replace('[{id: light, @lamp}]', '[{id: ready, @a2}]')
    line = Line()
    run = line.begin(text, 1)
    run.submit('K', line.script(second, 'second'), 1)
    run.go()
    # Section 2 is done with J at 5.0; its component is prepared before anything of K needs it.
    assert run.starts('ready') == [5.0]


def test_4_4_initialization_tasks_of_a_zone_never_overlap() -> None:
    text = """
    initialization: [{id: light, @lamp}, {id: ready, @a2}, {id: other, @b2}]
    sections:
      1: [{id: place, @a1, qty_change: 1}]
      2: [{id: work, @a2}]
      3: [{id: pack, @a3, qty_change: -1}]
    zones: {table: [light, ready]}
    """
    run = Line().run(text, 1)
    assert [run.starts(task) for task in ('light', 'other', 'ready')] == [[0.0], [0.0], [1.0]]
    assert run.ended


def test_4_4_in_a_section_the_list_decides() -> None:
    text = """
    sections:
      1: [{id: place, @a1, qty_change: 1}]
      2: [parallel: [{id: second, @b2}, {id: first, @a2}]]
      3: [{id: pack, @a3, qty_change: -1}]
    zones:
      table: [first, second]
    """
    run = Line().run(text)
    assert run.starts('second') == [3.0]
    assert run.starts('first') == [4.0]
