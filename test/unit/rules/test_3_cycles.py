"""Semantics 3.1 to 3.4: steps, source and sink, empty positions, turns."""

from __future__ import annotations

from fakes.line import THREE, Line, with_section

# --- 3.1 ------------------------------------------------------------------------------------


def test_3_1_steps_run_in_order() -> None:
    run = Line().run(with_section(2, '[{id: one, @a2}, {id: two, @b2}, {id: three, @a2}]'))
    assert [run.starts(task) for task in ('one', 'two', 'three')] == [[3.0], [4.0], [5.0]]


def test_3_1_a_group_ends_when_all_its_members_ended() -> None:
    text = with_section(
        2,
        """
        - parallel:
          - {id: short, @a2}
          - {id: long, @b2}
          - - {id: first, @arm}
            - {id: then, @arm}
        - {id: after, @a2}
        """,
    )
    run = Line(seconds={'b2': 3.0}).run(text)
    assert run.starts('short') == run.starts('long') == run.starts('first') == [3.0]
    assert run.starts('then') == [4.0]
    assert run.starts('after') == [6.0]


def test_3_1_group_failure_leaves_other_members_running() -> None:
    text = with_section(2, '[parallel: [{id: bad, @a2}, {id: long, @b2}]]')
    run = Line(seconds={'b2': 3.0}, faults={'a2': '#1=abort'}).run(text)
    assert run.times('hold.raised', task='bad') == [4.0]
    assert run.times('task.succeeded', task='long') == [6.0]
    assert run.starts('long') == [3.0]


# --- 3.2 ------------------------------------------------------------------------------------


def test_3_2_item_exists_from_start_of_source_cycle() -> None:
    text = with_section(
        1,
        """
        - {id: look, @a1, requires_conveyor: false}
        - id: place
          task: TASK_A
          action: /b1/do
          qty_change: 1
          args: {special_argument_2: "${results.look.measurement}"}
        """,
    )
    run = Line(results={'a1': {'measurement': 2.5}}).run(text)
    (placed,) = run.all('task.started', task='place')
    assert placed['args'] == {'special_argument_2': 2.5}
    assert run.times('item.placed', section=1) == [2.0]


def test_3_2_success_of_minus_one_removes_item() -> None:
    run = Line().run()
    assert run.times('item.removed', item='J/1', section=3, how='packed') == [7.0]
    assert run.state.sections[3].slot is None


def test_3_2_a_single_section_is_source_and_sink() -> None:
    text = 'sections:\n  1: [{id: place, @a1, qty_change: 1}, {id: pack, @b1, qty_change: -1}]'
    run = Line(1).run(text, 3)
    assert run.starts('place') == [0.0, 2.0, 4.0]
    assert run.all('belt.index_started') == []
    assert run.times('job.completed') == [6.0]
    assert run.counts() == {'started': 3, 'placed': 3, 'processed': 3, 'packed': 3}


def test_3_2_continued_plus_one_failure_leaves_empty_position() -> None:
    text = THREE.replace('qty_change: 1}', 'qty_change: 1, on_failure: continue}')
    run = Line(faults={'a1': '#1=abort'}).run(text, 2)
    assert run.times('item.missing', item='J/1', section=1) == [1.0]
    assert run.times('item.moved', item='J/1') == [3.0, 6.0]
    assert run.starts('work', item='J/1') == []
    assert run.times('position.ended', item='J/1', section=3) == [6.0]
    assert run.counts() == {
        'started': 2,
        'placed': 1,
        'processed': 1,
        'packed': 1,
        'missing': 1,
    }


def test_3_2_item_rejected_before_plus_one_leaves_empty_position() -> None:
    text = with_section(
        1,
        """
        - {id: pick, @a1, requires_conveyor: false, on_failure: reject}
        - {id: place, @b1, qty_change: 1}
        """,
    )
    run = Line(faults={'a1': '#2=abort'}).run(text, 2)
    assert run.starts('place') == [1.0]
    assert run.times('item.rejected', item='J/2') == [3.0]  # in a cycle begun ahead at 2.0
    # The belt has to rest: the position of item 2 must not appear under item 1.
    assert run.times('item.missing', item='J/2') == [4.0]
    assert run.counts() == {'started': 2, 'placed': 1, 'processed': 1, 'packed': 1, 'missing': 1}


def test_3_2_a_skipped_plus_one_leaves_an_empty_position() -> None:
    run = Line(faults={'a1': '#1=abort'}).run()
    run.answer('skip')
    run.go()
    assert run.times('item.missing') == [1.0]
    assert run.ended
    assert run.counts() == {'started': 1, 'missing': 1}


def test_3_2_removal_before_sink_leaves_empty_position() -> None:
    text = """
    sections:
      1: [{id: place, @a1, qty_change: 1}]
      2: [{id: test, @a2, on_failure: reject}]
      3: [{id: drop, @a3, qty_change: -1, runs_for: rejected}, {id: close, @b3}]
      4: [{id: pack, @a4, qty_change: -1}]
    """
    run = Line(4, faults={'a2': '#1=abort'}).run(text, 2)
    assert run.times('item.removed', item='J/1', section=3, how='rejected') == [7.0]
    assert run.starts('close', item='J/1') == []
    assert run.times('item.moved', item='J/1', section=4) == [9.0]
    assert run.times('position.ended', item='J/1', section=4) == [9.0]
    assert run.counts() == {'started': 2, 'placed': 2, 'processed': 1, 'packed': 1, 'rejected': 1}


def test_3_2_twins_remove_good_and_rejected_items() -> None:
    text = """
    sections:
      1: [{id: place, @a1, qty_change: 1}]
      2: [{id: test, @a2, on_failure: reject}]
      3:
        - {id: pack, @a3, qty_change: -1}
        - {id: drop, @b3, qty_change: -1, runs_for: rejected}
    """
    run = Line(faults={'a2': '#2=false'}).run(text, 3)
    assert run.all('item.removed', how='packed', item='J/2') == []
    assert run.starts('drop') == [9.0]
    assert run.counts()['packed'] == 2
    assert run.counts()['rejected'] == 1


def test_3_2_the_source_waits_while_its_slot_is_taken() -> None:
    """An item of a job that does nothing in the source section of the next one passes first."""
    first = """
    sections:
      1: [{id: place, @a1, qty_change: 1}]
      3: [{id: pack, @a3, qty_change: -1}]
    """
    second = """
    sections:
      2: [{id: place, @a2, qty_change: 1}]
      3: [{id: pack, @a3, qty_change: -1}]
    """
    line = Line()
    run = line.begin(first, 2)
    run.submit('K', line.script(second, 'second'), 2)
    run.go()
    assert run.all('hold.raised') == []
    assert run.ended
    assert run.counts('K')['packed'] == 2


# --- 3.3 ------------------------------------------------------------------------------------


def test_3_3_step_requires_conveyor_unless_script_says_false() -> None:
    text = with_section(2, '[{id: hand, @a2, requires_conveyor: false}, {id: work, @b2}]')
    run = Line(seconds={'a2': 0.5}).run(text)
    assert run.starts('hand') == [1.0]  # while the belt moves from 1 to 3
    assert run.starts('work') == [3.0]


def test_3_3_group_requires_conveyor_if_any_member_does() -> None:
    text = with_section(
        2, '[parallel: [{id: hand, @a2, requires_conveyor: false}, {id: work, @b2}]]'
    )
    run = Line().run(text)
    assert run.starts('hand') == run.starts('work') == [3.0]


def test_3_3_group_without_conveyor_runs_during_belt_move() -> None:
    text = with_section(
        2,
        """
        - parallel:
          - {id: left, @a2, requires_conveyor: false}
          - {id: right, @b2, requires_conveyor: false}
        """,
    )
    run = Line().run(text)
    assert run.starts('left') == run.starts('right') == [1.0]


def test_3_3_belt_waits_until_turn_is_complete() -> None:
    text = with_section(2, '[{id: work, @a2}, {id: write, @b2, requires_conveyor: false}]')
    run = Line(seconds={'b2': 7.0}).run(text)
    assert run.starts('write') == [4.0]
    assert run.times('belt.index_started') == [1.0, 11.0]


# --- 3.4 ------------------------------------------------------------------------------------


def test_3_4_source_has_turn_while_cycles_remain() -> None:
    run = Line(seconds={'a1': 5.0}).run(quantity=2)
    # At 8.0 item 1 has been worked on for long, and the belt waits for item 2 alone.
    assert run.starts('place') == [0.0, 7.0]
    assert run.times('belt.index_started')[:2] == [5.0, 12.0]


def test_3_4_the_next_queued_job_follows_at_once() -> None:
    line = Line()
    run = line.begin(THREE, 1)
    run.submit('K', line.script(THREE), 1)
    run.go()
    assert run.starts('place', job='K') == [3.0]
    assert run.times('item.moved', item='K/1', section=2) == run.times(
        'item.moved', item='J/1', section=3
    )


def test_3_4_a_section_without_an_item_counts_as_released() -> None:
    run = Line().run()
    assert run.times('belt.index_started') == [1.0, 4.0]


def test_3_4_section_takes_no_second_turn_for_item() -> None:
    run = Line(seconds={'a1': 4.0}).run(quantity=2)
    assert run.starts('work', item='J/1') == [6.0]
    assert run.times('turn.completed', section=2, item='J/1') == [7.0]


def test_3_4_an_empty_position_has_a_turn() -> None:
    text = THREE.replace('qty_change: 1}', 'qty_change: 1, on_failure: continue}')
    run = Line(faults={'a1': '#1=abort'}).run(text, 1)
    assert run.times('turn.completed', section=2, item='J/1') == [3.0]
    assert run.times('turn.completed', section=3, item='J/1') == [5.0]
