"""Our tables of job control and PackML, compared with the companion specifications.

What the nodesets do not say stands here as the specification says it, with its paragraph.
"""

from __future__ import annotations

import pytest
from nodeset_states import Nodeset, Transition

from bt_orchestrator.model.jobs.job_control import METHODS
from bt_orchestrator.model.packml import TRANSITIONS, Cause, PackmlState

RECEIVER, RECEIVER_WITH_SUB_STATES = 'ns=1;i=1002', 'ns=1;i=1008'
EXECUTE, MACHINE, BASE = 'ns=1;i=1', 'ns=1;i=2', 'ns=1;i=3'

BEGINS = {'Cleared': 'Clearing', 'Running': 'Resetting'}
"""Where a state begins that is a machine of its own (OPC 30050, figures 5 and 6)."""


@pytest.fixture(scope='module')
def job_control() -> Nodeset:
    return Nodeset('isa95_jobcontrol_v2')


@pytest.fixture(scope='module')
def pack_ml() -> Nodeset:
    return Nodeset('pack_ml')


@pytest.mark.parametrize('machine', [RECEIVER, RECEIVER_WITH_SUB_STATES])
def test_caused_job_transitions_match_nodeset(job_control: Nodeset, machine: str) -> None:
    theirs = {transition for transition in job_control.transitions(machine) if transition.cause}
    ours = {
        Transition(before.state, after.state, method.name)
        for method in METHODS
        for before, after in method.changes.items()
        if before is not None and after is not None
    }
    assert ours == theirs
    assert len(theirs) == 12


def test_job_starts_only_by_itself(job_control: Nodeset) -> None:
    [change] = [change for change in job_control.transitions(RECEIVER) if not change.cause]
    assert change == Transition('AllowedToStart', 'Running', '')


def test_we_have_every_method_of_job_control(job_control: Nodeset) -> None:
    assert {method.name for method in METHODS} == job_control.methods(RECEIVER)


def test_packml_matches_nodeset_except_completion(pack_ml: Nodeset) -> None:
    theirs = _flat(pack_ml)
    ours = {
        Transition(before.value, after.value, '' if cause is Cause.DONE else cause.name.title())
        for before, row in TRANSITIONS.items()
        for cause, after in row.items()
    }
    assert len(theirs) == 51
    assert theirs - ours == {Transition('Execute', 'Completing', 'ToComplete')}
    assert ours - theirs == {Transition('Execute', 'Completing', '')}


def test_the_states_of_packml_are_ours(pack_ml: Nodeset) -> None:
    names = {state for change in _flat(pack_ml) for state in (change.before, change.after)}
    assert names == {state.value for state in PackmlState}


def _flat(pack_ml: Nodeset) -> set[Transition]:
    """Return the transitions of all three machines between states that have no machine inside."""
    execute, machine = pack_ml.transitions(EXECUTE), pack_ml.transitions(MACHINE)
    inside = {'Running': {change.before for change in execute}}
    inside['Cleared'] = {change.before for change in machine} - {'Running'} | inside['Running']
    return {
        Transition(before, BEGINS.get(change.after, change.after), change.cause)
        for change in (*execute, *machine, *pack_ml.transitions(BASE))
        for before in inside.get(change.before, {change.before})
    }
