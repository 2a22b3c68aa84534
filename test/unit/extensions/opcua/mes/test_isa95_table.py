"""The table of the standard, written by hand: it is whole, and as the nodeset has it."""

from __future__ import annotations

from nodeset_states import Nodeset, Transition
from tables.standard import GONE, NONE, Cell, read_table

from bt_orchestrator.extensions.opcua.mes.methods import DIFFERENT, STATES, TABLE
from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.model.jobs.job_control import METHODS

CELLS = read_table()


def test_it_has_every_method_and_every_state() -> None:
    states = [NONE, *(word.value for word in JobWord)]
    assert set(CELLS) == {(method.name, state) for method in METHODS for state in states}
    assert len(CELLS) == 88


def test_its_transitions_are_those_of_the_nodeset() -> None:
    theirs = Nodeset('isa95_jobcontrol_v2').transitions('ns=1;i=1002')
    table = {
        Transition(state.partition('/')[0], cell.after, method)
        for (method, state), cell in CELLS.items()
        if cell.after not in {'', 'gone'} and state != NONE
    }
    assert table == {transition for transition in theirs if transition.cause}


def test_only_successful_calls_have_next_state() -> None:
    assert all((cell.status == 1) == bool(cell.after) for cell in CELLS.values())


def test_answers_match_standard_except_listed_differences() -> None:
    ours = {
        (method.name, state): (cell.status.value, cell.after, cell.is_later)
        for method, row in TABLE.items()
        for state, cell in zip(STATES, row, strict=True)
    }
    otherwise = {
        (name, state)
        for (name, state), (status, after, is_later) in ours.items()
        if is_later
        or not _agrees(CELLS[name, NONE if state is None else state.value], status, after)
    }
    assert len(ours) == len(CELLS)
    assert otherwise == {(method.name, state) for method, state in DIFFERENT}
    assert {key for key in otherwise if ours[key][2]} == {
        (name, state)
        for name in ('Stop', 'Abort')
        for state in (JobWord.RUNNING, JobWord.HELD, JobWord.SUSPENDED)
    }
    assert ours['Resume', JobWord.HELD][0] == 8


def _agrees(standard: Cell, status: int, after: JobWord | None) -> bool:
    if standard.status != 1:
        return status == standard.status
    word = GONE if after is None else after.value
    return status == 1 and standard.after in (word, word.partition('/')[0])
