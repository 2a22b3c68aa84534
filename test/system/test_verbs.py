"""The verbs that talk to a running node, each in a process of its own."""

from __future__ import annotations

import json
import signal
from pathlib import Path

import pytest
from bt_orchestrator_interfaces.srv import QueueCommand
from cell_processes import CellProcesses, StartCell, run_verb
from node_watcher import WHO
from program_process import ProgramProcess


def order_file(cell: CellProcesses, text: str) -> str:
    path = cell.folder / 'order.yaml'
    path.write_text(text)
    return str(path)


@pytest.mark.long
@pytest.mark.timeout(600)
def test_the_verbs_at_a_running_node(start_cell: StartCell) -> None:
    """The worker fails at its first attempt for each of the orders that are held."""
    cell = start_cell(fail=['worker.TASK_A#1=abort', 'worker.TASK_A#3=abort'])
    cell.connect()
    _a_hold_is_shown_and_answered(cell)
    _an_item_is_taken_off_the_belt(cell)
    _an_order_is_submitted_and_its_end_shown(cell)
    _orders_that_are_refused_end_with_1(cell)
    _the_last_events_and_then_the_wait_for_more(cell)
    _events_are_printed_up_to_a_count(cell)
    cell.stop()


def held(cell: CellProcesses, order: str) -> str:
    """Let an order be Held by its worker, with the item in section 2; return the hold."""
    cell.run_small(order=order)
    return str(cell.watch.until_held().id)


def _a_hold_is_shown_and_answered(cell: CellProcesses) -> None:
    hold, folder = held(cell, 'retried'), cell.folder
    status, output, _ = run_verb(folder, 'status')
    assert status == 0
    assert f'hold {hold}: section 2, work (TASK_A) of retried/1 at' in output

    wrong = run_verb(folder, 'answer', 'H99', 'retry', '--reason', 'x')
    assert wrong[0] == 1
    assert hold in wrong[2]
    assert run_verb(folder, 'answer', hold, 'retry')[0] == 2, 'a reason is required'
    assert run_verb(folder, 'answer', hold, 'dance', '--reason', 'x')[0] == 2
    status, output, _ = run_verb(
        folder, 'answer', hold, 'retry', '--reason', 'gripper cleaned', '--who', 'Ada'
    )
    assert status == 0
    decided = cell.watch.until('operator.decided', hold=hold)
    assert (decided['answer'], decided['who']) == ('retry', 'Ada')
    assert decided['reason'] == 'gripper cleaned'
    assert cell.watch.until_ended('retried').packed == 1


def _an_item_is_taken_off_the_belt(cell: CellProcesses) -> None:
    hold, folder = held(cell, 'broken'), cell.folder
    absent = run_verb(folder, 'remove-item', 'broken/9', '--reason', 'x')
    assert absent[0] == 1
    assert 'broken/1' in absent[2]
    status, output, _ = run_verb(folder, 'remove-item', 'broken/1', '--reason', 'broken')
    assert (status, output) == (0, 'broken/1 is off the belt\n')
    assert cell.watch.until('item.removed', item='broken/1')['how'] == 'by_hand'

    assert cell.watch.answer(hold, 'skip').accepted
    job = cell.watch.until_ended('broken')
    assert (job.packed, job.missing) == (0, 1)


def _an_order_is_submitted_and_its_end_shown(cell: CellProcesses) -> None:
    folder = cell.folder
    order = order_file(cell, '{order: WO-1, script: small, quantity: 2}')
    assert run_verb(folder, 'submit', order) == (0, 'WO-1 is queued\n', '')
    cell.watch.until_ended('WO-1')

    status, output, _ = run_verb(folder, 'status')
    assert status == 0
    assert 'WO-1 (small): Ended, 2 of 2 packed' in output
    status, output, _ = run_verb(folder, 'status', '--json')
    assert status == 0
    assert {job['id']: job['packed'] for job in json.loads(output)['jobs']}['WO-1'] == 2


def _orders_that_are_refused_end_with_1(cell: CellProcesses) -> None:
    folder = cell.folder
    given = order_file(cell, '{order: WO-1, script: small, quantity: 2}')
    again = run_verb(folder, 'submit', given)
    assert again[0] == 1
    assert 'WO-1' in again[2]

    unknown = order_file(cell, '{script: smal, quantity: 1}')
    status, output, _ = run_verb(folder, 'submit', '--json', unknown)
    answer = json.loads(output)
    assert (status, answer['accepted']) == (1, False)
    assert 'small' in answer['findings'][0]

    status, _, errors = run_verb(folder, 'submit', order_file(cell, '{quantity: 1}'))
    assert status == 1
    assert errors.startswith(f'{folder}/order.yaml:1:')

    both = order_file(cell, '{script: small, quantity: none, params: {lot: 1}}')
    status, _, errors = run_verb(folder, 'submit', both)
    findings = [line.removeprefix(f'{folder}/order.yaml:') for line in errors.splitlines()]
    assert [(finding.partition(' ')[0], finding.split('`')[1]) for finding in findings] == [
        ('1:27:', 'quantity'),
        ('1:47:', 'small'),
    ]


def _the_last_events_and_then_the_wait_for_more(cell: CellProcesses) -> None:
    watch = cell.watch
    cell.run_small(order='last')
    watch.until_ended('last')
    watch.ros.spin_until(lambda: watch.status.state == 'Complete', 'the end of all work')
    last = watch.status.seq
    listening = ProgramProcess(['events', '--last', '3'], cell.folder, 'last_events')
    listening.wait_ready(f'"seq": {last}')
    listening.send(signal.SIGINT)
    assert listening.wait() == 0
    seqs = [json.loads(line)['seq'] for line in listening.output.splitlines()]
    assert seqs == [last - 2, last - 1, last]
    quiet = ProgramProcess(['events'], cell.folder, 'quiet')
    watch.ros.spin_until(lambda: 'waiting for events' in quiet.errors, quiet.errors)
    assert quiet.errors == 'waiting for events of /bt_orchestrator; Ctrl-C ends\n'
    quiet.send(signal.SIGINT)
    assert quiet.wait() == 0


def _events_are_printed_up_to_a_count(cell: CellProcesses) -> None:
    watch, topic = cell.watch, f'{cell.watch.name}/events'
    watch.ros.spin_until(
        lambda: watch.ros.node.count_subscribers(topic) == 1, 'the earlier listeners to go'
    )
    listening = ProgramProcess(['events', '--count', '12'], cell.folder, 'events')
    try:
        watch.ros.spin_until(lambda: watch.ros.node.count_subscribers(topic) == 2, 'the listener')
        cell.run_small(order='counted', quantity=200)
        watch.ros.spin_until(lambda: listening.output.count('\n') == 12, 'twelve lines')
        assert listening.wait() == 0
    finally:
        listening.kill()
    records = [json.loads(line) for line in listening.output.splitlines()]
    assert len(records) == 12
    watch.ros.spin_until(lambda: records[-1] in watch.events, 'the same events')
    first = watch.events.index(records[0])
    assert records == watch.events[first : first + 12]
    stop = QueueCommand.Request(command='stop', job='counted', who=WHO, reason='test')
    assert watch.call(QueueCommand, 'queue/command', stop).accepted
    watch.until('job.completed', job='counted')


@pytest.mark.parametrize(
    'words',
    [
        ['status'],
        ['events', '--count', '1'],
        ['answer', 'H1', 'retry', '--reason', 'x'],
        ['remove-item', 'WO-1/1', '--reason', 'x'],
    ],
)
def test_without_a_node_every_verb_says_so(tmp_path: Path, words: list[str]) -> None:
    status, output, errors = run_verb(
        tmp_path, *words, '--node', '/nobody/bt_orchestrator', '--timeout', '0.5'
    )
    assert (status, output) == (1, '')
    assert '/nobody/bt_orchestrator' in errors
    assert 'within 0.5 s; is the tree node running' in errors


def test_submitting_without_a_node_says_so(tmp_path: Path) -> None:
    order = tmp_path / 'order.yaml'
    order.write_text('{script: small, quantity: 1}')
    status, _, errors = run_verb(tmp_path, 'submit', str(order), '--timeout', '0.5')
    assert status == 1
    assert 'is the tree node running' in errors
