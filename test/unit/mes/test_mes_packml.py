"""PackML's numbers, machines and transitions, compared with the nodeset of the OPC Foundation."""

from __future__ import annotations

import gzip
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from functools import lru_cache
from importlib.resources import files

import pytest

from bt_orchestrator.mes.packml import (
    CLEARED,
    COMMANDS,
    RUNNING,
    STATE_NUMBERS,
    WITHOUT,
    Machine,
    states_in,
    transitions_between,
)
from bt_orchestrator.model.packml import TRANSITIONS, VERBS, Cause, PackmlState

_NS = {'u': 'http://opcfoundation.org/UA/2011/03/UANodeSet.xsd'}
_MACHINES = {'ns=1;i=3': Machine.BASE, 'ns=1;i=2': Machine.MACHINE, 'ns=1;i=1': Machine.EXECUTE}
_CAUSES = {
    **{name: cause for cause in VERBS for name in (cause.value.title(),)},
    'Suspend': Cause.SUSPEND,
    'Unsuspend': Cause.UNSUSPEND,
    '': Cause.DONE,
}


@lru_cache
def _nodes() -> dict[str, ET.Element]:
    found = files('o6_nodeset_compiler') / 'bundle' / 'pack_ml.xml.gz'
    root = ET.fromstring(gzip.decompress(found.read_bytes()))
    return {node.get('NodeId', ''): node for node in root if node.get('NodeId')}


def _refs(node: ET.Element, kind: str) -> Iterator[tuple[bool, str]]:
    for ref in node.findall('u:References/u:Reference', _NS):
        if ref.get('ReferenceType') == kind:
            yield ref.get('IsForward') != 'false', ref.text or ''


def _name(node: str) -> str:
    return _nodes()[node].get('BrowseName', '').partition(':')[2]


def _machine_of(node: ET.Element) -> Machine:
    (parent,) = [to for forward, to in _refs(node, 'HasComponent') if not forward]
    return _MACHINES[parent]


def _target(node: ET.Element, kind: str) -> str:
    return next((_name(to) for forward, to in _refs(node, kind) if forward), '')


@lru_cache
def _transitions() -> frozenset[tuple[Machine, str, str, str]]:
    """Return machine, state before, cause and state after of each transition."""
    return frozenset(
        (
            _machine_of(node),
            _target(node, 'FromState'),
            _target(node, 'HasCause'),
            _target(node, 'ToState'),
        )
        for node in _nodes().values()
        if _target(node, 'ToState')
    )


def _numbers() -> dict[str, int]:
    """Return the StateNumber of each state."""
    found = {}
    for node in _nodes().values():
        if node.get('BrowseName') == 'StateNumber':
            (parent,) = [to for forward, to in _refs(node, 'HasProperty') if not forward]
            text = ''.join(node.find('u:Value', _NS).itertext())  # type: ignore[union-attr]
            found[_name(parent)] = int(text)
    return found


def test_the_states_have_the_numbers_of_the_nodeset() -> None:
    ours = {state.value: number for state, number in STATE_NUMBERS.items()}
    theirs = _numbers()
    assert theirs == {**ours, RUNNING: 18, CLEARED: 19}


def _ours_as_theirs() -> Iterator[tuple[Machine, str, str, str]]:
    names = {cause: name for name, cause in _CAUSES.items()}
    for before, row in TRANSITIONS.items():
        for cause, after in row.items():
            for one in transitions_between(before, after):
                # Each machine names its own; an inner one that is left has none.
                if one.machine is _outermost(before, after):
                    yield one.machine, one.before, names[cause], one.after


def _outermost(before: PackmlState, after: PackmlState) -> Machine:
    return next(transitions_between(before, after)).machine


def test_every_transition_of_the_cell_is_in_the_nodeset_and_the_other_way_round() -> None:
    ours, theirs = frozenset(_ours_as_theirs()), _transitions()
    to_complete = (Machine.EXECUTE, 'Execute', 'ToComplete', 'Completing')
    by_itself = (Machine.EXECUTE, 'Execute', '', 'Completing')
    assert theirs - ours == {to_complete}  # the cell completes by itself
    assert ours - theirs == {by_itself}


def test_a_transition_has_the_name_of_the_nodeset() -> None:
    names = {_name(id_) for id_, node in _nodes().items() if _target(node, 'ToState')}
    ours = {
        one.name
        for before, row in TRANSITIONS.items()
        for after in row.values()
        for one in transitions_between(before, after)
    }
    assert ours == names


@pytest.mark.parametrize(
    ('state', 'expected'),
    [
        (PackmlState.ABORTED, {Machine.BASE: 'Aborted'}),
        (PackmlState.STOPPED, {Machine.BASE: 'Cleared', Machine.MACHINE: 'Stopped'}),
        (
            PackmlState.HELD,
            {Machine.BASE: 'Cleared', Machine.MACHINE: 'Running', Machine.EXECUTE: 'Held'},
        ),
    ],
)
def test_the_machines_are_nested(state: PackmlState, expected: dict[Machine, str]) -> None:
    assert states_in(state) == expected


def test_every_method_of_the_nodeset_is_a_command_or_is_said_to_be_missing() -> None:
    methods = {
        _name(id_)
        for id_, node in _nodes().items()
        if node.tag.endswith('UAMethod') and _has_cause(node)
    }
    assert methods == {*COMMANDS, *WITHOUT}
    for name, request in COMMANDS.items():
        assert request.word == VERBS[_CAUSES[name]]


def _has_cause(method: ET.Element) -> bool:
    return any(not forward for forward, _ in _refs(method, 'HasCause'))
