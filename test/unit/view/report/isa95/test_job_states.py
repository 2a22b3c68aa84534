"""States of jobs, compared with the nodeset of the OPC Foundation."""

from __future__ import annotations

import pytest
from fakes.job_control_nodeset import INTERRUPTED, PREPARE, RECEIVER, name_of, nodes, state_numbers

from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.view.report.isa95.codes import (
    STATE_NUMBERS,
    SUBSTATES,
    State,
    are_known,
    has_all,
    states_of,
)


def test_numbers_are_those_of_the_nodeset() -> None:
    assert state_numbers(RECEIVER) == STATE_NUMBERS
    assert state_numbers(INTERRUPTED) == SUBSTATES['Interrupted']
    assert SUBSTATES['AllowedToStart'].items() <= state_numbers(PREPARE).items()


def test_every_state_of_a_job_has_its_number() -> None:
    assert {word.state for word in JobWord} == set(STATE_NUMBERS)
    assert {word.substate for word in JobWord} - {''} == set(SUBSTATES['Interrupted'])


def test_substate_follows_state_and_names_machine() -> None:
    assert states_of(JobWord.RUNNING) == (State('Running', 3),)
    top, sub = states_of(JobWord.SUSPENDED)
    assert top == State('Interrupted', 4)
    assert sub == State('Suspended', 2, 'InterruptedSubstates')
    names = {name_of(node) for node in nodes().values() if node.get('ParentNodeId') == RECEIVER}
    assert sub.machine in names


def test_waiting_job_has_substate_waiting() -> None:
    _, sub = states_of(JobWord.ALLOWED_TO_START, awaits_start=True)
    assert sub == State('Waiting', 1, 'AllowedToStartSubstates')
    assert len(states_of(JobWord.NOT_ALLOWED_TO_START, awaits_start=True)) == 1


@pytest.mark.parametrize(
    ('asked', 'words'),
    [
        ([State('', 4)], {JobWord.HELD, JobWord.SUSPENDED}),
        ([State('Interrupted', 0)], {JobWord.HELD, JobWord.SUSPENDED}),
        ([State('', 4), State('', 1, 'InterruptedSubstates')], {JobWord.HELD}),
        ([State('', 5)], {JobWord.ENDED}),
        ([State('', 1)], {JobWord.NOT_ALLOWED_TO_START}),
    ],
)
def test_jobs_are_found_by_number_or_by_text(asked: list[State], words: set[JobWord]) -> None:
    assert {word for word in JobWord if has_all(states_of(word), asked)} == words
    assert are_known(asked)


@pytest.mark.parametrize(
    ('asked', 'is_known'),
    [
        ([State('', 2), State('', 1, 'AllowedToStartSubstates')], True),
        ([State('nonsense', 0)], False),
        ([State('', 7)], False),
        ([State('', 3), State('', 1, 'InterruptedSubstates')], False),
    ],
)
def test_impossible_job_state_is_not_known(asked: list[State], is_known: bool) -> None:
    assert are_known(asked) is is_known
