"""What the record says of operators' decisions: who, from where, and why (semantics 7.1)."""

from __future__ import annotations

import json
import socket
from pathlib import Path
from typing import Any

import pytest
from cell_processes import CellProcesses, StartCell, run_verb

HERE = f'bt-orchestrator at {socket.gethostname()}'


@pytest.fixture
def held_cell(start_cell: StartCell, tmp_path: Path) -> CellProcesses:
    """Give a cell with a journal that is Held by its worker, which always fails."""
    journal = tmp_path / 'cell' / 'journal.sqlite3'
    cell = start_cell(fail=['worker.TASK_A=abort'], run_options=['--journal', str(journal)])
    cell.connect()
    cell.run_small()
    cell.watch.until_held()
    return cell


def operators_events(cell: CellProcesses) -> list[dict[str, Any]]:
    """Return what the journal of a cell tells of its operators, by the verb that reads it."""
    words = ['events', '--journal', str(cell.folder / 'journal.sqlite3'), '--event', 'operator.']
    status, output, errors = run_verb(cell.folder, *words)
    assert (status, errors) == (0, '')
    return [json.loads(line) for line in output.splitlines()]


def said(cell: CellProcesses, *words: str, who: str, reason: str) -> tuple[int, str]:
    """Carry out a verb for somebody; return its exit status, and what it said."""
    status, output, errors = run_verb(cell.folder, *words, '--who', who, '--reason', reason)
    return status, output + errors


@pytest.mark.parametrize('answer', ['retry', 'mark_done', 'skip', 'reject', 'abort_job'])
def test_7_1_an_answer_is_recorded_with_who_where_from_and_why(
    held_cell: CellProcesses, answer: str
) -> None:
    (hold,) = held_cell.watch.status.holds
    assert said(held_cell, 'answer', hold.id, answer, who='Ann', reason='seen')[0] == 0
    held_cell.watch.until('hold.released', hold=hold.id)
    (decided,) = (e for e in operators_events(held_cell) if e['who'] == 'Ann')
    assert {
        'event': 'operator.decided',
        'answer': answer,
        'hold': hold.id,
        'who': 'Ann',
        'origin': HERE,
        'reason': 'seen',
    }.items() <= decided.items()
    held_cell.stop()


def test_7_1_a_removal_and_what_is_refused_are_recorded_too(held_cell: CellProcesses) -> None:
    (hold,) = held_cell.watch.status.holds
    asked = [
        (('answer', 'H99', 'retry'), {'command': 'retry', 'hold': 'H99'}),
        (('remove-item', hold.item), {'answer': 'remove_item', 'item': hold.item}),
        (('remove-item', hold.item), {'command': 'remove_item', 'item': hold.item}),
    ]
    answers = [said(held_cell, *words, who='Ben', reason=words[0]) for words, _ in asked]
    assert [status for status, _ in answers] == [1, 0, 1]
    recorded = [e for e in operators_events(held_cell) if e['who'] == 'Ben']
    for event, (words, about), (status, told) in zip(recorded, asked, answers, strict=True):
        expected = {'event': 'operator.decided', 'reason': words[0], 'origin': HERE, **about}
        if status:
            expected |= {'event': 'operator.refused', 'message': told.rstrip('\n')}
        assert expected.items() <= event.items()
    held_cell.stop()


def test_6_3_results_given_with_mark_done_fit_the_action_and_are_recorded(
    held_cell: CellProcesses,
) -> None:
    (hold,) = held_cell.watch.status.holds

    def give(result: str) -> tuple[int, str]:
        words = ('answer', hold.id, 'mark_done', '--result', result)
        return said(held_cell, *words, who='Ann', reason='by hand')

    status, told = give('measurement=high')
    assert status == 1
    assert 'results: `measurement` must be a number' in told
    assert give('mesurement=1')[0] == 1
    assert give('measurement=2.5') == (0, f'hold {hold.id}: mark_done\n')
    marked = held_cell.watch.until('task.marked_done')
    assert marked['results'] == {'measurement': 2.5}
    refused = [e for e in operators_events(held_cell) if e['event'] == 'operator.refused']
    assert [e['command'] for e in refused] == ['mark_done', 'mark_done']
    held_cell.stop()
