"""What the record says of operators' decisions: who, from where, and why (semantics 7.1)."""

from __future__ import annotations

import json
import socket
from pathlib import Path
from typing import Any

import pytest
from cell_processes import CellProcesses, StartCell, run_verb, small_script

HERE = f'bt-orchestrator at {socket.gethostname()}'


FIRST_ATTEMPTS = (1, 3, 4, 5, 6, 7, 8)
"""Of each order, counted by the worker; the second one is that of the retry."""


@pytest.mark.long
@pytest.mark.timeout(600)
def test_what_operators_decide_is_on_record(start_cell: StartCell, tmp_path: Path) -> None:
    """The worker fails at each order, and the line is idle again after each step."""
    journal = tmp_path / 'cell' / 'journal.sqlite3'
    cell = start_cell(
        fail=[f'worker.TASK_A#{number}=abort' for number in FIRST_ATTEMPTS],
        run_options=['--journal', str(journal)],
    )
    cell.connect()
    for answer in ('retry', 'mark_done', 'skip', 'reject', 'abort_job'):
        _7_1_an_answer_is_recorded_with_who_where_from_and_why(cell, answer)
    _7_1_a_removal_and_what_is_refused_are_recorded_too(cell)
    _6_3_results_given_with_mark_done_fit_the_action_and_are_recorded(cell)
    cell.stop()


DRAINING = small_script().replace('qty_change: -1', 'qty_change: -1, runs_for: all')
"""A script that packs what is rejected or aborted, too: nothing stays on the line."""


def held(cell: CellProcesses, order: str, script: str = DRAINING) -> Any:
    """Let an order be Held by its worker, with the item in section 2; return the hold."""
    cell.watch.submit(cell.script(script), order=order)
    hold = cell.watch.until_held()
    assert hold.item == f'{order}/1'
    return hold


def until_over(cell: CellProcesses, order: str) -> None:
    """Wait until an order has come to an end, and nothing of it is on the line."""
    cell.watch.until_status(
        lambda s: (
            any(job.id == order and job.state in ('Ended', 'Aborted') for job in s.jobs)
            and not any(section.slot for section in s.sections)
        ),
        f'the end of {order}',
    )


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


def _7_1_an_answer_is_recorded_with_who_where_from_and_why(
    cell: CellProcesses, answer: str
) -> None:
    hold, who = held(cell, answer), f'Ann {answer}'
    assert said(cell, 'answer', hold.id, answer, who=who, reason='seen')[0] == 0
    cell.watch.until('hold.released', hold=hold.id)
    (decided,) = (e for e in operators_events(cell) if e['who'] == who)
    assert {
        'event': 'operator.decided',
        'answer': answer,
        'hold': hold.id,
        'who': who,
        'origin': HERE,
        'reason': 'seen',
    }.items() <= decided.items()
    until_over(cell, answer)


def _7_1_a_removal_and_what_is_refused_are_recorded_too(cell: CellProcesses) -> None:
    hold = held(cell, 'removed', small_script())
    asked = [
        (('answer', 'H99', 'retry'), {'command': 'retry', 'hold': 'H99'}),
        (('remove-item', hold.item), {'answer': 'remove_item', 'item': hold.item}),
        (('remove-item', hold.item), {'command': 'remove_item', 'item': hold.item}),
    ]
    answers = [said(cell, *words, who='Ben', reason=words[0]) for words, _ in asked]
    assert [status for status, _ in answers] == [1, 0, 1]
    recorded = [e for e in operators_events(cell) if e['who'] == 'Ben']
    for event, (words, about), (status, message) in zip(recorded, asked, answers, strict=True):
        expected = {'event': 'operator.decided', 'reason': words[0], 'origin': HERE, **about}
        if status:
            expected |= {'event': 'operator.refused', 'message': message.rstrip('\n')}
        assert expected.items() <= event.items()
    assert cell.watch.answer(hold.id, 'skip').accepted
    until_over(cell, 'removed')


def _6_3_results_given_with_mark_done_fit_the_action_and_are_recorded(
    cell: CellProcesses,
) -> None:
    hold = held(cell, 'measured')

    def give(result: str) -> tuple[int, str]:
        words = ('answer', hold.id, 'mark_done', '--result', result)
        return said(cell, *words, who='Cem', reason='by hand')

    status, output = give('measurement=high')
    assert status == 1
    assert 'results: `measurement` must be a number' in output
    assert give('mesurement=1')[0] == 1
    assert give('measurement=2.5') == (0, f'hold {hold.id}: mark_done\n')
    marked = cell.watch.until('task.marked_done', job='measured')
    assert marked['results'] == {'measurement': 2.5}
    refused = [
        event
        for event in operators_events(cell)
        if (event['event'], event['who']) == ('operator.refused', 'Cem')
    ]
    assert [event['command'] for event in refused] == ['mark_done', 'mark_done']
    assert cell.watch.until_ended('measured').packed == 1
