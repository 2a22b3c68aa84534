"""Semantics 3.5 to 3.8: the belt, its failures, overlap, early release."""

from __future__ import annotations

from fakes.line import THREE, Line, with_section

# --- 3.5 ------------------------------------------------------------------------------------


def test_3_5_the_belt_waits_for_all_turns() -> None:
    run = Line(seconds={'a2': 4.0}).begin(quantity=2).go(until=5.0)
    assert run.waits()['belt'] == 'waiting for section 2 to finish with J/1'
    run.go()
    assert run.times('belt.index_started')[:2] == [1.0, 7.0]


def test_3_5_empty_belt_begins_next_beat_without_move() -> None:
    text = 'sections:\n  1: [{id: place, @a1, qty_change: 1}, {id: pack, @b1, qty_change: -1}]'
    run = Line(2).run(text, 2)
    assert run.times('beat.started') == [2.0]
    assert run.all('belt.index_started') == []


def test_3_5_next_beat_begins_for_cycle_begun_ahead() -> None:
    """The source has no cycles left to begin, but one that waits for its beat."""
    text = 'sections:\n  1: [{id: place, @a1, qty_change: 1}, {id: pack, @b1, qty_change: -1}]'
    run = Line(1, faults={'b1': '#1=abort'}).run(text, 2)
    run.answer('mark_done')
    run.go()
    assert len(run.all('beat.started', beat=2)) == 1
    assert run.ended, run.waits()


def test_3_5_without_items_and_cycles_the_belt_rests() -> None:
    run = Line().run()
    assert len(run.all('belt.indexed')) == 2
    assert run.all('beat.started') == []


def test_3_5_indexing_is_a_task_of_the_conveyor() -> None:
    run = Line().run()
    (first, _) = run.all('task.started', task='index')
    assert first['time'] == 1.0
    assert (first['name'], first['action']) == ('MOVE_ONE_INDEX', '/belt/do')
    assert not {'job', 'section', 'item'} & first.keys()
    assert run.times('task.succeeded', task='index') == run.times('belt.indexed') == [3.0, 6.0]


def test_3_5_everything_shifts_one_slot() -> None:
    run = Line().run(quantity=3)
    moved = [(r['time'], r['item'], r['section']) for r in run.all('item.moved')]
    assert moved == [
        (3.0, 'J/1', 2),
        (6.0, 'J/1', 3),
        (6.0, 'J/2', 2),
        (9.0, 'J/2', 3),
        (9.0, 'J/3', 2),
        (12.0, 'J/3', 3),
    ]


def test_3_5_a_failed_move_holds_and_nothing_has_moved() -> None:
    run = Line(faults={'conveyor': '#1=abort'}).run()
    (hold,) = run.state.holds.values()
    assert (hold.task, hold.reason) == ('index', 'aborted')
    assert hold.answers == ('retry', 'mark_done', 'abort_job')
    assert run.all('item.moved') == []
    assert run.state.indexing


def test_3_5_a_failed_move_is_retried_by_the_operator() -> None:
    run = Line(faults={'conveyor': '#1=abort'}).run()
    run.answer('retry')
    run.go()
    assert run.starts('index') == [1.0, 3.0, 6.0]
    assert run.times('item.moved', section=2) == [5.0]
    assert run.ended


def test_3_5_a_failed_move_marked_done_has_moved() -> None:
    run = Line(faults={'conveyor': '#1=abort'}).run()
    run.answer('mark_done')
    assert run.times('item.moved', section=2) == run.times('belt.indexed') == [3.0]
    run.go()
    assert run.ended


def test_3_5_the_conveyors_own_retries() -> None:
    run = Line(belt='retries: 2', faults={'conveyor': '#1=abort #2=reject'}).run()
    assert run.starts('index') == [1.0, 3.0, 3.0, 6.0]
    assert run.all('hold.raised') == []


def test_3_5_abort_job_aborts_belt_jobs_and_keeps_hold() -> None:
    text = THREE.replace('qty_change: -1', 'qty_change: -1, runs_for: all')
    line = Line(faults={'conveyor': '#2=abort'})
    run = line.begin(text, 1)
    run.submit('K', line.script(text), 5)
    run.submit('L', line.script(text), 1)
    run.go()
    run.answer('abort_job')
    assert run.order('job.aborting', 'job') == ['J', 'K']
    assert [hold.task for hold in run.state.holds.values()] == ['index']
    run.answer('retry')
    run.go()
    assert run.ended
    assert run.counts('J')['rejected'] == 1
    assert run.counts('K')['rejected'] == 1
    assert run.counts('L')['packed'] == 1


def test_3_5_the_conveyors_policy_may_be_abort_job() -> None:
    text = THREE.replace('qty_change: -1', 'qty_change: -1, runs_for: all')
    run = Line(belt='on_failure: abort_job', faults={'conveyor': '#1=abort'}).run(text, 5)
    assert run.times('job.aborting') == [3.0]
    assert [hold.task for hold in run.state.holds.values()] == ['index']
    run.answer('mark_done')
    run.go()
    assert run.times('job.aborted') != []


# --- 3.6 ------------------------------------------------------------------------------------


def overrun() -> str:
    """Return a line whose operators can reject an item that no task takes out then."""
    return with_section(2, '- {id: work, @a2}')


def test_3_6_belt_never_moves_item_past_last_section() -> None:
    run = Line(faults={'a2': '#1=abort'}).run(overrun(), 2)
    run.answer('reject')
    run.go()
    (hold,) = run.state.holds.values()
    assert (hold.reason, hold.item, hold.section) == ('overrun', 'J/1', 3)
    assert run.state.sections[3].slot == 'J/1'
    assert len(run.all('belt.index_started')) == 2


def test_3_6_remove_item_resolves_it() -> None:
    run = Line(faults={'a2': '#1=abort'}).run(overrun(), 2)
    run.answer('reject')
    run.go()
    refused = run.answer('skip')
    assert not refused.accepted
    assert 'remove-item J/1' in refused.message
    assert run.remove('J/1').accepted
    run.go()
    assert run.state.holds == {}
    assert run.ended
    assert run.counts() == {
        'started': 2,
        'placed': 2,
        'processed': 1,
        'packed': 1,
        'missing': 1,
        'removed': 1,
    }


# --- 3.7 ------------------------------------------------------------------------------------

AHEAD = """
sections:
  1: [{id: pick, @a1, requires_conveyor: false}, {id: place, @b1, qty_change: 1}]
  2: [{id: fetch, @a2, requires_conveyor: false}, {id: work, @b2}]
  3: [{id: open, @a3, requires_conveyor: false}, {id: pack, @b3, qty_change: -1}]
"""


def test_3_7_leading_steps_run_while_the_belt_moves() -> None:
    run = Line().run(AHEAD, 2)
    assert run.times('belt.index_started') == [2.0, 5.0, 8.0]
    assert run.starts('pick') == [0.0, 2.0]
    assert run.starts('fetch') == [2.0, 5.0]
    assert run.starts('work') == [4.0, 7.0]
    assert run.starts('open') == [5.0, 8.0]


def test_3_7_source_goes_ahead_after_its_own_cycle() -> None:
    run = Line(seconds={'b2': 9.0}).run(AHEAD, 3)
    # Section 2 works until 13.0; the source picked part 3 at once, and places it at 15.0.
    assert run.times('belt.index_started')[1] == 13.0
    assert run.starts('pick', item='J/3') == [5.0]
    assert run.starts('place', item='J/3') == [15.0]


def test_3_7_other_sections_go_ahead_at_index_start() -> None:
    run = Line(seconds={'b2': 9.0}).run(AHEAD, 2)
    assert run.starts('open', item='J/1') == [13.0]


def test_3_7_conveyor_step_waits_for_its_own_beat() -> None:
    run = Line(seconds={'b2': 9.0}).begin(AHEAD, 3).go(until=8.0)
    assert run.waits()['section 1'] == 'waiting for the belt to move'
    assert run.state.sections[1].cycle is not None
    run = Line(seconds={'b2': 9.0}).begin(AHEAD, 3).go(until=14.0)
    assert run.waits()['section 1'] == 'waiting for the belt to rest'


def test_3_7_never_more_than_one_cycle_ahead() -> None:
    text = with_section(2, '- {id: write, @a2, requires_conveyor: false}')
    run = Line(seconds={'a2': 0.5}).run(text, 2)
    assert run.starts('write', item='J/1') == [1.0]
    assert run.starts('write', item='J/2') == [4.0]
    run = Line(seconds={'b2': 30.0}).run(AHEAD, 4)
    assert run.starts('pick') == [0.0, 2.0, 5.0, 37.0]


# --- 3.8 ------------------------------------------------------------------------------------

EARLY = with_section(
    2,
    """
      release_conveyor: after_last_conveyor_task
      tasks:
        - {id: fetch, @a2, requires_conveyor: false}
        - {id: work, @b2}
        - {id: clean, @a2, requires_conveyor: false}
    """,
)


def test_3_8_last_conveyor_step_completes_turn() -> None:
    run = Line(seconds={'a2': 1.5}).run(EARLY, 2)
    assert run.times('turn.completed', section=2, item='J/1') == [4.0]
    assert run.starts('clean', item='J/1') == [4.0]
    assert run.times('belt.index_started')[1] == 4.0  # the trailing step runs until 5.5


def test_3_8_the_next_cycle_waits_for_the_trailing_steps() -> None:
    run = Line(seconds={'a2': 4.0}).run(EARLY, 2)
    assert run.starts('clean', item='J/1') == [6.0]
    assert run.times('cycle.completed', section=2, item='J/1') == [10.0]
    assert run.starts('fetch', item='J/2') == [10.0]
    assert run.starts('work', item='J/2') == [14.0]


def test_3_8_end_of_cycle_release_delays_belt() -> None:
    text = EARLY.replace('after_last_conveyor_task', 'end_of_cycle')
    run = Line(seconds={'a2': 1.5}).run(text, 2)
    assert run.times('turn.completed', section=2, item='J/1') == [5.5]
    assert run.times('belt.index_started')[1] == 5.5


def test_3_8_job_completes_after_its_trailing_steps() -> None:
    run = Line(seconds={'a2': 9.0}).run(EARLY)
    assert run.times('item.removed') == [14.0]
    assert run.times('job.completed') == [20.0]


def test_3_8_the_section_of_the_sink_may_release_early() -> None:
    text = with_section(
        3,
        """
          release_conveyor: after_last_conveyor_task
          tasks:
            - {id: pack, @a3, qty_change: -1}
            - {id: close, @b3, requires_conveyor: false}
        """,
    )
    run = Line(seconds={'b3': 2.5}).run(text, 2)
    assert run.times('item.removed') == [7.0, 10.5]
    assert run.starts('close') == [7.0, 10.5]
    assert run.ended
