"""Semantics 7.1, 7.3, 7.4: holds, operators, and why nothing happens."""

from __future__ import annotations

import pytest
from fakes.commands import Abort
from fakes.line import THREE, Line, with_section
from fakes.virtual_run import VirtualRun

from bt_orchestrator.extensions.page.web.wording import wordings

# --- 7.1: what a hold stops -----------------------------------------------------------------


def test_7_1_the_held_section_starts_nothing() -> None:
    text = with_section(
        2, '[parallel: [{id: bad, @a2}, [{id: one, @b2}, {id: two, @b2}]], {id: next, @a2}]'
    )
    line = Line(faults={'a2': '#1=abort'}, seconds={'b2': 3.0})
    run = line.run(text)
    assert run.times('task.succeeded', task='one') == [6.0]  # nothing is cancelled
    assert run.starts('two') == run.starts('next') == []
    assert run.waits()['section 2'] == 'waiting for an answer to hold 1 (bad: aborted)'
    run.answer('mark_done')
    assert run.starts('two') == [6.0]
    run.go()
    assert run.ended


def test_7_1_the_held_section_skips_nothing_either() -> None:
    """A skip counts as if the task had run (4.2), and the answer may reject the item."""
    text = with_section(
        2,
        '[parallel: [{id: bad, @a2}, [{id: one, @b2}, {id: two, @b2, runs_for: rejected}]]]',
    ).replace('qty_change: -1', 'qty_change: -1, runs_for: all')
    run = Line(faults={'a2': '#1=abort'}, seconds={'b2': 3.0}).run(text)
    assert run.times('task.succeeded', task='one') == [6.0]
    assert run.all('task.skipped') == []
    run.answer('reject')
    run.go()
    assert run.starts('two') == [6.0]
    assert run.ended


def test_7_1_other_sections_finish_current_cycle_only() -> None:
    text = """
    sections:
      1: [{id: pick, @a1, requires_conveyor: false}, {id: place, @b1, qty_change: 1}]
      2: [{id: work, @a2}]
      3: [{id: open, @a3}, {id: pack, @b3, qty_change: -1}]
    """
    line = Line(faults={'a2': '#2=abort'}, seconds={'a3': 3.0})
    run = line.run(text, 5)
    # The second `work` fails at 8.0, while section 3 opens item 1 until 10.0.
    assert run.times('hold.raised') == [8.0]
    assert run.starts('pack', item='J/1') == [10.0]
    assert run.starts('pick', item='J/4') == []
    assert run.times('belt.index_started') == [2.0, 5.0]
    assert run.now == 11.0


def test_7_1_no_section_begins_ahead_while_the_cell_holds() -> None:
    run = Line(faults={'a2': '#1=abort'}, seconds={'a1': 3.0}).run(quantity=3)
    assert run.times('hold.raised') == [6.0]
    assert run.order('cycle.started', 'item') == ['J/1', 'J/1', 'J/2']


def test_7_1_cell_is_held_once_no_goal_runs() -> None:
    run = Line(faults={'a2': '#1=abort'}, seconds={'a1': 5.0}).run(quantity=2)
    changes = [(r['time'], r['state']) for r in run.all('cell.state_changed')][-2:]
    assert changes == [(8.0, 'Holding'), (12.0, 'Held')]


def test_7_1_after_the_answer_the_cell_goes_on() -> None:
    run = Line(faults={'a2': '#1=abort'}).run()
    run.answer('retry')
    changes = [r['state'] for r in run.all('cell.state_changed')][-4:]
    assert changes == ['Holding', 'Held', 'Unholding', 'Execute']
    run.go()
    assert run.ended


def test_7_1_each_answer_is_recorded_with_who_and_why() -> None:
    run = Line(faults={'a2': '#1=abort'}).run()
    run.answer('skip')
    (decided,) = run.all('operator.decided')
    assert (decided['answer'], decided['who'], decided['reason'], decided['hold']) == (
        'skip',
        'Ann',
        'it looked so',
        '1',
    )


def test_7_1_an_answer_to_no_hold_is_refused() -> None:
    run = Line(faults={'a2': '#1=abort'}).run()
    before = len(run.records)
    refused = [run.answer('retry', hold='7'), run.answer('again')]
    assert [answer.accepted for answer in refused] == [False, False]
    assert refused[0].message == 'there is no hold 7; holds now: 1'
    assert 'can be answered with retry, mark_done, skip, reject, abort_job' in refused[1].message
    recorded = [(r['event'], r['command'], r['who'], r['hold']) for r in run.records[before:]]
    assert recorded == [
        ('operator.refused', 'retry', 'Ann', '7'),
        ('operator.refused', 'again', 'Ann', '1'),
    ]


# --- 7.1: every answer on every kind of task ------------------------------------------------

ALL = """
initialization: [{id: ready, @b1}]
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: work, @a2}]
  3: [{id: pack, @a3, qty_change: -1, runs_for: all}]
lateral_dependencies:
  - {flag: first, upstream: place, downstream: work}
  - {flag: last, upstream: work, downstream: pack}
"""
COMPONENTS = {'ready': 'b1', 'place': 'a1', 'work': 'a2', 'pack': 'a3'}


def held_at(task: str, quantity: int = 2) -> VirtualRun:
    """Run until the first attempt of a task has failed and holds."""
    return Line(faults={COMPONENTS[task]: '#1=abort'}).run(ALL, quantity)


@pytest.mark.parametrize('task', COMPONENTS)
def test_7_1_retry_makes_a_new_attempt(task: str) -> None:
    run = held_at(task)
    at = run.now
    run.answer('retry')
    assert run.starts(task)[1] == at
    assert [r['attempt'] for r in run.all('task.started', task=task)][:2] == [1, 2]
    run.go()
    assert run.counts()['packed'] == 2


@pytest.mark.parametrize('task', COMPONENTS)
def test_7_1_mark_done_is_as_if_it_had_succeeded(task: str) -> None:
    run = held_at(task)
    at = run.now
    run.answer('mark_done')
    assert run.times('task.marked_done', task=task) == [at]
    if task == 'place':
        assert run.times('item.placed', item='J/1') == [at]
    if task == 'pack':
        assert run.times('item.removed', item='J/1', how='packed') == [at]
    if task in ('place', 'work'):
        assert run.times('flag.raised', task=task)[0] == at
    run.go()
    assert run.counts()['packed'] == 2


@pytest.mark.parametrize('task', ['ready', 'place', 'work'])
def test_7_1_skip_performs_flags_only(task: str) -> None:
    run = held_at(task)
    at = run.now
    run.answer('skip')
    (skipped,) = run.all('task.skipped', task=task)[:1]
    assert skipped['time'] == at
    assert skipped['reason'] == 'Ann decided skip: it looked so'
    run.go()
    assert run.counts()['packed'] == (1 if task == 'place' else 2)
    assert run.counts().get('missing', 0) == (task == 'place')
    assert run.counts().get('nonconforming', 0) == 0


def test_7_1_skip_is_not_offered_on_minus_one() -> None:
    run = held_at('pack')
    (hold,) = run.state.holds.values()
    assert hold.answers == ('retry', 'mark_done', 'reject', 'abort_job')
    assert not run.answer('skip').accepted


@pytest.mark.parametrize('task', ['place', 'work'])
def test_7_1_reject_rejects_the_item(task: str) -> None:
    run = held_at(task)
    at = run.now
    run.answer('reject')
    assert run.times('item.rejected', item='J/1') == [at]
    run.go()
    assert run.ended
    assert run.counts()['packed'] == 1
    assert run.counts()['missing' if task == 'place' else 'rejected'] == 1


def test_7_1_reject_on_minus_one_leaves_item_to_twin() -> None:
    text = """
    sections:
      1: [{id: place, @a1, qty_change: 1}]
      2: [{id: work, @a2}]
      3: [{id: pack, @a3, qty_change: -1}, {id: drop, @b3, qty_change: -1, runs_for: rejected}]
    """
    run = Line(faults={'a3': '#1=abort'}).run(text, 2)
    run.answer('reject')
    assert run.starts('drop', item='J/1') == [7.0]
    run.go()
    assert run.counts()['rejected'] == 1


@pytest.mark.parametrize('task', COMPONENTS)
def test_7_1_abort_job_ends_the_job(task: str) -> None:
    run = held_at(task, quantity=9)
    started = {'ready': 0, 'place': 1, 'work': 2, 'pack': 3}[task]
    run.answer('abort_job')
    run.go()
    if task == 'pack':  # nothing takes the item out any more
        assert [hold.reason for hold in run.state.holds.values()] == ['overrun']
        run.remove('J/1')
        run.go()
    assert run.counts().get('started', 0) == started
    assert run.counts().get('packed', 0) == 0
    assert run.order('job.aborted', 'job') == ['J']


def test_7_1_reject_is_not_offered_on_initialization() -> None:
    run = held_at('ready')
    assert not run.answer('reject').accepted


# --- 7.1: remove_item -----------------------------------------------------------------------


def test_7_1_remove_item_leaves_an_empty_position() -> None:
    run = Line().begin(quantity=2).go(until=4.0)
    assert run.remove('J/1').accepted
    run.go()
    assert run.times('item.removed', item='J/1', how='by_hand', section=2) == [4.0]
    assert run.times('item.moved', item='J/1', section=3) == [6.0]
    assert run.starts('pack') == [9.0]
    assert run.times('position.ended', item='J/1') == [6.0]


def test_7_1_remove_item_while_its_task_runs() -> None:
    text = with_section(2, '[{id: work, @a2}, {id: more, @b2}]')
    run = Line(seconds={'a2': 3.0}).begin(text, 1).go(until=3.0)
    assert run.remove('J/1').accepted
    run.go()
    assert run.times('task.succeeded', task='work') == [6.0]
    assert run.starts('more') == []
    assert run.ended
    assert run.counts() == {'started': 1, 'placed': 1, 'missing': 1, 'removed': 1}


def test_7_1_item_can_be_removed_during_packing() -> None:
    run = Line(seconds={'a3': 3.0}).begin(quantity=1).go(until=6.0)
    assert run.remove('J/1').accepted
    run.go()
    assert run.ended
    assert run.all('item.removed', how='packed') == []
    assert run.times('position.ended', section=3) == [9.0]


def test_7_1_remove_item_while_the_belt_moves() -> None:
    run = Line().begin(quantity=1).go(until=1.0)
    assert run.state.indexing
    assert run.remove('J/1').accepted
    run.go()
    assert run.starts('work') == []
    assert run.ended


@pytest.mark.parametrize('task', ['work', 'pack'])
@pytest.mark.parametrize('answer', ['mark_done', 'skip'])
def test_7_1_removed_item_offers_no_retry(task: str, answer: str) -> None:
    run = held_at(task, quantity=1)
    assert run.remove('J/1').accepted
    (hold,) = run.state.holds.values()
    assert hold.answers == ('mark_done', 'skip', 'abort_job')
    refusal = 'no retry: the task would be skipped (empty position); '
    assert hold.answers_why == f'{refusal}no reject: the item is not on the belt'
    assert not run.answer('retry').accepted
    run.answer(answer)
    run.go()
    assert run.ended
    assert run.counts()['missing'] == 1


def test_7_1_rejected_item_offers_no_retry() -> None:
    text = with_section(2, '[parallel: [{id: one, @a2}, {id: two, @b2}]]')
    text = text.replace('qty_change: -1', 'qty_change: -1, runs_for: all')
    run = Line(faults={'a2': '#1=abort', 'b2': '#1=abort'}).run(text)
    run.answer('reject', hold='1')
    assert run.state.holds['2'].answers == ('mark_done', 'skip', 'abort_job')
    run.answer('skip', hold='2')
    run.go()
    assert run.counts()['rejected'] == 1


def test_7_1_aborted_job_retries_task_for_rejected_items() -> None:
    run = held_at('pack', quantity=1)
    run.control('abort', 'J')
    (hold,) = run.state.holds.values()
    assert hold.answers == ('retry', 'mark_done')
    assert hold.answers_why == (
        'no skip: the item would not leave the belt; no reject: the item is rejected already; '
        'no abort_job: the job is being aborted'
    )
    run.answer('retry')
    run.go()
    assert run.ended
    assert run.counts()['rejected'] == 1


def test_7_1_unneeded_initialization_offers_no_retry() -> None:
    run = held_at('ready')
    run.control('abort', 'J')
    (hold,) = run.state.holds.values()
    assert hold.answers == ('mark_done', 'skip')
    refusal = 'no retry: the task would be skipped (job aborted); '
    assert hold.answers_why == f'{refusal}no abort_job: the job is being aborted'
    run.answer('skip')
    run.go()
    assert run.ended


def test_7_1_the_move_aborts_each_job_once() -> None:
    run = Line(faults={'conveyor': '#1=abort'}).run(ALL)
    run.answer('abort_job')
    (hold,) = run.state.holds.values()
    assert hold.answers == ('retry', 'mark_done')
    assert hold.answers_why == 'no abort_job: no job on the belt is left to abort'


# --- 7.1: `reject` is for an item whose section still has its turn -----------------------------

PACKED = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2:
    release_conveyor: after_last_conveyor_task
    tasks: [{id: work, @a2}, {id: rinse, @b2, requires_conveyor: false}]
  3: [{id: pack, @a3, qty_change: -1, runs_for: all}, {id: label, @b3}]
"""
"""`rinse` trails, and `label` runs when its item has been packed."""


@pytest.mark.parametrize(('task', 'component'), [('rinse', 'b2'), ('label', 'b3')])
def test_7_1_reject_is_not_offered_after_turn_or_packing(task: str, component: str) -> None:
    run = Line(faults={component: '#1=abort'}).run(PACKED)
    (hold,) = run.state.holds.values()
    assert (hold.task, hold.answers) == (task, ('retry', 'mark_done', 'skip', 'abort_job'))
    (raised,) = run.all('hold.raised')  # `rinse` before its item was packed
    assert tuple(raised['answers']) == hold.answers
    assert not run.answer('reject').accepted
    run.answer('retry')
    run.go()
    assert run.counts() == {'started': 1, 'placed': 1, 'processed': 1, 'packed': 1}


def test_7_1_reject_is_withdrawn_once_item_is_packed() -> None:
    text = PACKED.replace(
        '[{id: pack, @a3, qty_change: -1, runs_for: all}, {id: label, @b3}]',
        '[parallel: [{id: pack, @a3, qty_change: -1, runs_for: all}, {id: label, @b3}]]',
    )
    run = Line(faults={'b3': '#1=abort'}, seconds={'a3': 3.0}).run(text)
    (hold,) = run.all('hold.raised')
    assert 'reject' in hold['answers']
    assert run.state.holds['1'].answers == ('retry', 'mark_done', 'skip', 'abort_job')


# --- 7.1: where it is open whether the slot holds the item ---------------------------------------


@pytest.mark.parametrize(
    ('task', 'answers', 'question'),
    [
        ('place', ('retry', 'mark_done', 'skip'), 'placed in section 1'),
        ('pack', ('retry', 'mark_done'), 'taken out of section 3'),
    ],
)
@pytest.mark.parametrize(
    ('fault', 'reason'), [('#1=die:1', 'server_lost'), ('#1=cancel', 'in_doubt')]
)
def test_7_1_only_answers_that_say_what_the_slot_holds(
    task: str, answers: tuple[str, ...], question: str, fault: str, reason: str
) -> None:
    """Any other would let the belt move with a slot that nobody has looked at."""
    run = Line(faults={COMPONENTS[task]: fault}).run(ALL)
    (hold,) = run.state.holds.values()
    assert (hold.reason, hold.answers) == (reason, answers)
    assert f'was J/1 {question}? mark_done if it was, else retry' in hold.message
    assert 'mark_done, sonst retry' in wordings()['de'].hold(hold)
    why = f'no reject or abort_job: it is not known whether J/1 was {question}'
    assert hold.answers_why.endswith(why)
    run.answer('mark_done')
    run.go()
    assert run.ended


@pytest.mark.parametrize(
    ('task', 'first', 'then'),
    [
        ('place', ('retry', 'mark_done', 'skip'), ('mark_done', 'skip')),
        ('pack', ('retry', 'mark_done'), ('retry', 'mark_done')),
    ],
)
def test_7_1_cell_abort_hold_asks_about_slot(
    task: str, first: tuple[str, ...], then: tuple[str, ...]
) -> None:
    run = Line(seconds={COMPONENTS[task]: 9.0}).begin(ALL)
    run.go(until={'place': 1.0, 'pack': 7.0}[task])
    assert [key.task for key in run.state.running] == [task]
    run.command(Abort)
    run.go()
    (hold,) = run.state.holds.values()
    assert (hold.reason, hold.answers) == ('in_doubt', first)
    run.control('abort', 'J')
    (hold,) = run.state.holds.values()
    assert hold.answers == then
    assert ('no retry: ' in hold.answers_why) == ('retry' not in then)


@pytest.mark.parametrize('word', ['acknowledge', 'comment'])
def test_7_1_remark_is_recorded_and_hold_remains(word: str) -> None:
    run = Line(faults={'a2': '#1=abort'}).run()
    before, holds = len(run.records), dict(run.state.holds)
    assert run.answer(word).accepted
    run.go()
    assert [record['event'] for record in run.records[before:]] == ['operator.decided']
    (decision,) = run.all('operator.decided', answer=word)
    assert (decision['hold'], decision['reason']) == ('1', 'it looked so')
    assert run.state.holds == holds
    assert word not in holds['1'].answers
    assert run.answer('retry').accepted


def test_7_1_only_open_pause_takes_remarks() -> None:
    run = Line().begin(quantity=2).go(until=3.0)
    run.pause()
    assert run.answer('acknowledge', '1').accepted
    assert run.answer('comment', '1').accepted
    assert run.answer('comment', '2').message == 'there is no hold 2; holds now: 1'


def test_7_1_removing_item_not_on_belt_is_refused() -> None:
    run = Line().begin(quantity=2).go(until=3.0)
    before = len(run.records)
    for item in ('J/2', 'K/1'):
        answer = run.remove(item)
        assert not answer.accepted
        assert answer.message == f'{item} is not on the belt; on it: J/1'
    run.remove('J/1')
    assert run.remove('J/1').message == 'J/1 is not on the belt; on it: nothing'
    names = [record['event'] for record in run.records[before:]]
    refused = 'operator.refused'
    assert names == [refused, refused, 'operator.decided', 'item.removed', refused]


# --- 7.3 ------------------------------------------------------------------------------------


def test_7_3_cell_resumes_when_all_holds_are_released() -> None:
    run = Line(faults={'a2': '#2=abort', 'a3': '#1=abort'}).run(quantity=3)
    assert list(run.state.holds) == ['1', '2']
    assert [hold.section for hold in run.state.holds.values()] == [3, 2]
    run.answer('mark_done', hold='1')
    run.go()
    assert run.state.packml.value == 'Held'
    assert len(run.all('belt.index_started')) == 2
    run.answer('mark_done', hold='2')
    assert run.state.packml.value == 'Execute'
    assert len(run.all('belt.index_started')) == 3
    run.go()
    assert run.ended


def test_7_3_every_hold_has_an_id_of_its_own() -> None:
    run = Line(faults={'a2': '#1=abort #2=abort'}).run()
    run.answer('retry')
    run.go()
    assert run.order('hold.raised', 'hold') == ['1', '2']
    assert not run.answer('retry', hold='1').accepted


# --- 7.4 ------------------------------------------------------------------------------------


def test_7_4_every_part_shows_its_wait_during_hold() -> None:
    run = Line(4, faults={'a3': '#1=abort'}).run(
        """
        sections:
          1: [{id: place, @a1, qty_change: 1}]
          3: [{id: work, @a3}]
          4: [{id: pack, @a4, qty_change: -1}]
        """,
        9,
    )
    held = 'waiting for an answer to hold 1 (work: aborted)'
    assert run.waits() == {
        'section 1': held,
        'section 2': held,
        'section 3': held,
        'section 4': held,
        'belt': 'waiting for section 3 to finish with J/1',
    }


def test_7_4_reasons_of_a_line_at_work() -> None:
    run = Line(4, seconds={'a3': 9.0}).begin(
        """
        sections:
          1: [{id: place, @a1, qty_change: 1}]
          3: [{id: work, @a3}]
          4: [{id: pack, @a4, qty_change: -1}]
        """,
        2,
    )
    run.go(until=1.0)
    assert run.waits() == {
        'section 1': 'waiting for the belt to rest',
        'section 2': 'waiting for the belt to rest',
        'section 3': 'waiting for the belt to rest',
        'section 4': 'waiting for the belt to rest',
    }
    run.go(until=7.0)
    assert run.waits() == {
        'section 1': 'waiting for an item',
        'section 2': 'waiting for the belt to move',
        'section 4': 'waiting for an item',
        'belt': 'waiting for section 3 to finish with J/1',
    }


def test_7_4_a_stuck_line_names_the_circle() -> None:
    text = THREE + 'lateral_dependencies: [{flag: f, upstream: pack, downstream: work}]\n'
    run = Line().run(text, 3)
    assert run.waits() == {
        'section 1': 'waiting for the belt to move',
        'section 2': 'waiting for pack to set flag f',
        'section 3': 'waiting for an item',
        'belt': 'waiting for section 2 to finish with J/1',
    }


# --- 7.1: what lacks a result ---------------------------------------------------------------

LACKING = """
sections:
  1: [{id: place, @a1, qty_change: 1}, {id: look, @b1, on_failure: continue}]
  2: [{id: use, @a2, args: {special_argument_2: "${results.look.measurement}"}}]
  3: [{id: pack, @a3, qty_change: -1}]
"""
LACKING_SINK = LACKING.replace(
    'args: {special_argument_2: "${results.look.measurement}"}', 'timeout: 9'
).replace(
    '{id: pack, @a3, ',
    '{id: pack, @a3, args: {special_argument_2: "${results.look.measurement}"}, ',
)


@pytest.mark.parametrize(
    ('text', 'answers'),
    [
        (LACKING, ('mark_done', 'skip', 'reject', 'abort_job')),
        (LACKING_SINK, ('mark_done', 'reject', 'abort_job')),
    ],
    ids=['a task', 'the sink'],
)
def test_7_1_missing_result_offers_no_retry(text: str, answers: tuple[str, ...]) -> None:
    run = Line(faults={'b1': '#1=abort'}).run(text)
    (hold,) = run.state.holds.values()
    assert (hold.reason, hold.answers) == ('missing_result', answers)
    assert hold.answers_why.startswith('no retry: the result would be missing again')
    assert not run.answer('retry').accepted
    assert run.answer('mark_done').accepted
    run.go()
    assert run.ended
