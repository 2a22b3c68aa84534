"""Rule 7.10: reasons of stops are on record, and change nothing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from fakes.operator import ann
from fakes.request_bench import RequestBench

from bt_orchestrator.model.by import Role

STORY: Sequence[tuple[str, Mapping[str, Any]]] = (
    ('cell.pause', {}),
    ('cell.resume', {}),
    ('component.out_of_service', {'component': 'a2'}),
    ('component.in_service', {'component': 'a2'}),
    ('job.pause', {'job': 'A'}),
    ('job.resume', {'job': 'A'}),
    ('cell.stop', {}),
    ('cell.abort', {}),
)
WITH_CODE = ('pause', 'out_of_service', 'stop', 'abort')


HELD = 12.0
"""When a task of the line is held."""


def begun(folder: Path, until: float = HELD, *, has_journal: bool = True) -> RequestBench:
    cell = RequestBench(folder, has_journal=has_journal)
    orders = '{orders: [{script: boxes, quantity: 3, order: A}]}'
    assert cell.ask_named('queue.add', orders).accepted
    cell.pass_time(until)
    return cell


def without_codes(cell: RequestBench) -> Sequence[object]:
    """Return all events as they are without the codes of reasons."""
    events = []
    for event in cell.store.read():
        plain = {**vars(event), 'event': event.event}
        plain.pop('code', None)
        events.append(plain)
    return events


def test_7_10_a_reason_changes_no_other_event(tmp_path: Path) -> None:
    cells = []
    for code in ('', 'JAM'):
        cell = begun(tmp_path, until=2.0)
        for name, given in STORY:
            has_code = code and name.rpartition('.')[2] in WITH_CODE
            more: Mapping[str, Any] = {'code': code} if has_code else {}
            assert cell.ask(name, **given, **more)
        cells.append(cell)
    assert without_codes(cells[0]) == without_codes(cells[1])
    codes = [event.code for event in cells[1].records('operator.decided') if event.code]
    assert codes == ['JAM'] * 5


def test_7_10_an_unknown_code_is_refused(tmp_path: Path) -> None:
    cell = begun(tmp_path)
    assert not cell.ask('hold.retry', hold='1', code='JAMM')
    assert 'did you mean `JAM`?' in cell.records('operator.refused')[-1].message
    assert not cell.records('hold.released')


def test_7_10_emergency_command_ignores_unknown_code(tmp_path: Path) -> None:
    cell = begun(tmp_path)
    for name in ('cell.pause', 'cell.stop', 'cell.abort'):
        answer = cell.ask_named(name, '{code: TOOTH}')
        assert answer.accepted
        assert "there is no reason 'TOOTH'" in answer.message
    assert not any(event.code for event in cell.records('operator.decided'))


def test_7_10_repeated_stop_and_abort_give_earlier_reason(tmp_path: Path) -> None:
    cell = begun(tmp_path)
    assert cell.ask('cell.stop')
    assert not cell.ask('cell.stop')
    for name, code in (('cell.stop', 'LUNCH'), ('cell.abort', 'JAM')):
        cell.pass_time(60.0)
        before = cell.sim.state.seq
        assert cell.ask(name, code=code)
        cell.pass_time(60.0)
        (event,) = cell.store.read(after=before)
        assert (event.event, vars(event)['code']) == ('operator.decided', code)
        assert name == 'cell.abort' or cell.ask('cell.abort')


@pytest.mark.parametrize(
    ('stop', 'message'),
    [
        (':1', 'no stop of the line began with event 1'),
        (':99999', 'no stop of the line began with event 99999'),
        ('12', 'a stop has a name as in'),
        ('other:12', 'of another history'),
    ],
)
def test_7_10_a_stop_that_does_not_exist_is_refused(
    tmp_path: Path, stop: str, message: str
) -> None:
    cell = begun(tmp_path)
    assert not cell.ask('stop.classify', stop=stop, code='JAM')
    assert message in cell.records('operator.refused')[-1].message


def test_7_10_operators_classify_a_stop_while_it_stands(tmp_path: Path) -> None:
    cell = begun(tmp_path)
    cell.sim.clock.call_at(40.0, lambda: None)
    cell.pass_time(40.0)
    reason = next(event for event in cell.records('cell.stop_reason_changed') if event.stop_reason)
    name = f':{reason.seq}'
    for role, may in ((Role.VIEW, False), (Role.MES, False), (Role.OPERATE, True)):
        by = replace(ann(), role=role)
        assert cell.ask('stop.classify', by, stop=name, code='JAM') is may
    decided = cell.records('operator.decided')[-1]
    assert (decided.answer, decided.stop, decided.code) == ('classify', name, 'JAM')


def test_7_10_resume_gives_reason_of_named_hold(tmp_path: Path) -> None:
    cell = begun(tmp_path, until=2.0)
    assert cell.ask('cell.pause')
    (pause,) = cell.sim.state.pauses
    assert not cell.ask('cell.resume', code='LUNCH')
    assert 'name it, --hold N' in cell.records('operator.refused')[-1].message
    assert cell.ask('cell.resume', hold=pause.id, code='LUNCH')
    decided = cell.records('operator.decided')[-1]
    assert (decided.answer, decided.hold, decided.code) == ('resume', pause.id, 'LUNCH')


def test_7_10_a_classification_needs_a_code(tmp_path: Path) -> None:
    cell = begun(tmp_path)
    stop = next(event for event in cell.records('cell.stop_reason_changed') if event.stop_reason)
    assert not cell.ask('stop.classify', stop=f':{stop.seq}', code='')
    assert 'the code of the reason is empty' in cell.records('operator.refused')[-1].message


def test_7_10_a_node_without_a_journal_classifies_nothing(tmp_path: Path) -> None:
    cell = begun(tmp_path, has_journal=False)
    for stop, code in ((':1', 'JAM'), ('other:12', 'TOOTH')):
        assert not cell.ask('stop.classify', stop=stop, code=code)
        assert cell.records('operator.refused')[-1].message == (
            'this node keeps no journal, so a stop has no name that lasts; start it with '
            '--journal FILE'
        )
    assert not any(decision.answer == 'classify' for decision in cell.records('operator.decided'))
