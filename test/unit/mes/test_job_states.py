"""States of jobs, compared with the nodeset of the OPC Foundation."""

from __future__ import annotations

import pytest
from fakes.job_control_nodeset import INTERRUPTED, RECEIVER, name_of, nodes, state_numbers

from bt_orchestrator.mes.job_states import NUMBERS, SUBSTATES, State, states_of, words_in
from bt_orchestrator.model.jobs.isa95 import JobWord


def test_numbers_are_those_of_the_nodeset() -> None:
    assert state_numbers(RECEIVER) == NUMBERS
    assert state_numbers(INTERRUPTED) == SUBSTATES['Interrupted']


def test_every_state_of_a_job_has_its_number() -> None:
    assert {word.state for word in JobWord} == set(NUMBERS)
    assert {word.substate for word in JobWord} - {''} == set(SUBSTATES['Interrupted'])


def test_a_substate_follows_its_state_and_names_its_machine() -> None:
    assert states_of(JobWord.RUNNING) == (State('Running', 3),)
    top, sub = states_of(JobWord.SUSPENDED)
    assert top == State('Interrupted', 4)
    assert sub == State('Suspended', 2, 'InterruptedSubstates')
    names = {name_of(node) for node in nodes().values() if node.get('ParentNodeId') == RECEIVER}
    assert sub.machine in names


@pytest.mark.parametrize(
    ('asked', 'words'),
    [
        ([State('', 4)], {JobWord.HELD, JobWord.SUSPENDED}),
        ([State('Interrupted', 0)], {JobWord.HELD, JobWord.SUSPENDED}),
        ([State('', 4), State('', 1, 'InterruptedSubstates')], {JobWord.HELD}),
        ([State('', 5)], {JobWord.ENDED}),
        ([State('', 1)], {JobWord.NOT_ALLOWED_TO_START}),
        ([State('nonsense', 0)], set()),
        ([State('', 7)], set()),
        ([], set()),
    ],
)
def test_jobs_are_found_by_number_or_by_text(asked: list[State], words: set[JobWord]) -> None:
    assert words_in(asked) == words
