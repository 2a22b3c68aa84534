"""Semantics 7.2: `clear` needs a statement of the whole belt, and takes no stale or wrong one."""

from __future__ import annotations

import pytest
from fakes.commands import Abort, Clear, Reset, Start
from fakes.line import Line, with_section
from fakes.virtual_run import VirtualRun

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.judging.belt_statement import AsShown, Slots, believed, parse_slots


def aborted(at: float = 3.5) -> VirtualRun:
    """Abort while section 2 works on item 1 and section 1 places item 2."""
    run = Line().begin(with_section(2, '[{id: work, @a2}, {id: more, @b2}]'), 3).go(until=at)
    run.command(Abort)
    run.go(until=run.now)
    assert run.state.packml.value == 'Aborted'
    return run


def clear(run: VirtualRun, text: str) -> Answer:
    return run.command(Clear, belt=parse_slots(text.split(',')))


def refused(run: VirtualRun, text: str) -> str:
    before = run.all('operator.decided')
    answer = clear(run, text)
    assert not answer.accepted
    assert run.state.packml.value == 'Aborted'
    assert run.all('operator.decided') == before
    return answer.message


def go_on(run: VirtualRun) -> None:
    for hold in list(run.state.holds.values()):
        assert run.answer('retry' if 'retry' in hold.answers else 'skip', hold.id).accepted
    run.command(Reset)
    run.command(Start)
    run.go()


def test_7_2_a_belt_that_is_as_believed_is_confirmed() -> None:
    run = aborted()
    assert believed(run.state) == '1=empty,2=J/1,3=empty'
    assert clear(run, believed(run.state)).accepted
    assert run.states[-2:] == ['Clearing', 'Stopped']
    assert run.all('item.removed') == []
    go_on(run)
    assert run.counts()['packed'] == 3


def test_7_2_clear_removes_item_no_longer_there() -> None:
    run = aborted()
    assert clear(run, '1=empty,2=empty,3=empty').accepted
    (removed,) = run.all('item.removed')
    assert (removed['item'], removed['section'], removed['how']) == ('J/1', 2, 'by_hand')
    go_on(run)
    assert run.ended
    assert (run.counts()['packed'], run.counts()['missing']) == (2, 1)


def test_7_2_every_slot_has_to_be_stated() -> None:
    run = aborted()
    assert refused(run, '2=J/1') == (
        'slot 1, 3 is not stated; say of every slot from 1 to 3 what stands there; '
        'the cell believes 1=empty,2=J/1,3=empty'
    )
    assert 'slot 4 does not exist' in refused(run, '1=empty,2=J/1,3=empty,4=empty')


@pytest.mark.parametrize(
    ('belt', 'remedy'),
    [
        ('1=empty,2=empty,3=J/1', 'J/1 belongs into slot 2: put it there, or take it off'),
        ('1=J/2,2=J/1,3=empty', 'if place did place it, answer hold 2 with mark_done first'),
        ('1=empty,2=K/1,3=empty', 'no such item is on the line; take it off and say empty'),
    ],
)
def test_7_2_clear_refuses_misplaced_item_with_remedy(belt: str, remedy: str) -> None:
    assert refused(aborted(), belt).endswith(remedy)


def test_7_2_clear_refuses_item_taken_off_before() -> None:
    run = aborted()
    run.remove('J/1')
    assert refused(run, '1=empty,2=J/1,3=empty').endswith('take it off and say empty')
    assert clear(run, '1=empty,2=empty,3=empty').accepted


def test_7_2_clear_refuses_outdated_belt_picture() -> None:
    run = aborted()
    seen = run.state.seq
    run.remove('J/1')
    stale = run.command(Clear, belt=AsShown(seen))
    assert not stale.accepted
    assert 'the belt has changed since the status with seq' in stale.message
    assert not run.command(Clear, belt=AsShown(run.state.seq + 5)).accepted
    assert run.command(Clear, belt=AsShown(run.state.seq)).accepted


def test_7_2_other_changes_keep_belt_picture_valid() -> None:
    run = aborted()
    seen = run.state.seq
    for hold in list(run.state.holds):
        run.answer('retry', hold)
    assert run.command(Clear, belt=AsShown(seen)).accepted


@pytest.mark.parametrize(('answer', 'slot'), [('mark_done', 2), ('retry', 1)])
def test_7_2_open_belt_move_is_answered_first(answer: str, slot: int) -> None:
    run = aborted(at=2.0)
    assert run.state.indexing
    assert refused(run, '1=J/1,2=empty,3=empty') == (
        'it is open whether the belt has moved; answer hold 1 first: mark_done if it has, retry '
        'if it has not'
    )
    assert run.answer(answer).accepted
    assert believed(run.state).split(',')[slot - 1] == f'{slot}=J/1'
    assert clear(run, believed(run.state)).accepted
    go_on(run)
    assert run.counts()['packed'] == 3


def test_7_2_taking_item_out_ends_overrun() -> None:
    text = with_section(3, '[{id: pack, @a3, qty_change: -1}]')
    run = Line(faults={'a2': '#1=abort'}).run(text, 2)
    run.answer('reject')
    run.go()
    assert [hold.reason for hold in run.state.holds.values()] == ['overrun']
    run.command(Abort)
    run.go(until=run.now)
    there = believed(run.state).replace('3=J/1', '3=empty')
    assert clear(run, there).accepted
    assert not run.state.holds


@pytest.mark.parametrize('words', [['1'], ['one=J/1'], ['1='], ['1=J/1', '1=empty']])
def test_7_2_a_statement_that_cannot_be_read_is_refused(words: list[str]) -> None:
    with pytest.raises(CommandRefused, match='slot'):
        parse_slots(words)


def test_7_2_slots_are_read_with_blanks() -> None:
    assert parse_slots(['1=WO-1/3', ' 2 = empty ']) == Slots({1: 'WO-1/3', 2: 'empty'})
