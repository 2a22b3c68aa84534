"""The table of the standard, written by hand: it is whole, and as the nodeset has it."""

from __future__ import annotations

from isa95_table import NONE, read_table
from nodeset_states import Nodeset, Transition

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
    assert table == {one for one in theirs if one.cause}


def test_what_succeeds_has_a_state_that_follows_and_what_fails_has_none() -> None:
    assert all((cell.status == 1) == bool(cell.after) for cell in CELLS.values())
