"""The verbs that talk to a running node, each in a process of its own."""

from __future__ import annotations

import json
import signal
from pathlib import Path

import pytest
from cell_processes import CellProcesses, StartCell, run_verb, small_script
from program_process import ProgramProcess


def order_file(cell: CellProcesses, text: str) -> str:
    path = cell.folder / 'order.yaml'
    path.write_text(text)
    return str(path)


def small_order(cell: CellProcesses, order: str = 'WO-1', quantity: int = 2) -> str:
    cell.script(small_script())
    return order_file(cell, f'{{order: {order}, script: small, quantity: {quantity}}}')


def test_an_order_is_submitted_and_its_end_shown(small_cell: CellProcesses) -> None:
    folder = small_cell.folder
    assert run_verb(folder, 'submit', small_order(small_cell)) == (0, 'WO-1 is queued\n', '')
    small_cell.watch.until_ended('WO-1')

    status, output, _ = run_verb(folder, 'status')
    assert status == 0
    assert 'WO-1 (small): Ended, 2 of 2 packed' in output
    status, output, _ = run_verb(folder, 'status', '--json')
    assert status == 0
    assert json.loads(output)['jobs'][0]['packed'] == 2
    small_cell.stop()


def test_orders_that_are_refused_end_with_1(small_cell: CellProcesses) -> None:
    folder = small_cell.folder
    small_cell.run_small()
    again = run_verb(folder, 'submit', small_order(small_cell))
    assert again[0] == 1
    assert 'WO-1' in again[2]

    unknown = order_file(small_cell, '{script: smal, quantity: 1}')
    status, output, _ = run_verb(folder, 'submit', '--json', unknown)
    answer = json.loads(output)
    assert (status, answer['accepted']) == (1, False)
    assert 'small' in answer['findings'][0]

    status, _, errors = run_verb(folder, 'submit', order_file(small_cell, '{quantity: 1}'))
    assert status == 1
    assert errors.startswith(f'{small_cell.folder}/order.yaml:1:')

    both = order_file(small_cell, '{script: small, quantity: none, params: {lot: 1}}')
    status, _, errors = run_verb(folder, 'submit', both)
    found = [line.removeprefix(f'{small_cell.folder}/order.yaml:') for line in errors.splitlines()]
    assert [(one.partition(' ')[0], one.split('`')[1]) for one in found] == [
        ('1:27:', 'quantity'),
        ('1:47:', 'small'),
    ]
    small_cell.stop()


def test_the_last_events_and_then_the_wait_for_more(small_cell: CellProcesses) -> None:
    small_cell.run_small()
    watch = small_cell.watch
    watch.ros.spin_until(lambda: watch.status.state == 'Complete', 'the end of all work')
    last = watch.status.seq
    listening = ProgramProcess(['events', '--last', '3'], small_cell.folder, 'last_events')
    listening.wait_ready(f'"seq": {last}')
    listening.send(signal.SIGINT)
    assert listening.wait() == 0
    seqs = [json.loads(line)['seq'] for line in listening.output.splitlines()]
    assert seqs == [last - 2, last - 1, last]
    quiet = ProgramProcess(['events'], small_cell.folder, 'quiet')
    small_cell.watch.ros.spin_until(lambda: 'waiting for events' in quiet.errors, quiet.errors)
    assert quiet.errors == 'waiting for events of /bt_orchestrator; Ctrl-C ends\n'
    quiet.send(signal.SIGINT)
    assert quiet.wait() == 0
    small_cell.stop()


def test_events_are_printed_up_to_a_count(small_cell: CellProcesses) -> None:
    listening = ProgramProcess(['events', '--count', '12'], small_cell.folder, 'events')
    try:
        ros = small_cell.watch.ros
        topic = f'{small_cell.watch.name}/events'
        ros.spin_until(lambda: ros.node.count_subscribers(topic) == 2, 'the listener')
        small_cell.run_small(quantity=200)
        small_cell.watch.ros.spin_until(lambda: listening.output.count('\n') == 12, 'twelve lines')
        assert listening.wait() == 0
    finally:
        listening.kill()
    records = [json.loads(line) for line in listening.output.splitlines()]
    assert len(records) == 12
    events = small_cell.watch.events
    small_cell.watch.ros.spin_until(lambda: records[-1] in events, 'the same events')
    first = events.index(records[0])
    assert records == events[first : first + 12]
    small_cell.stop()


@pytest.fixture
def held_cell(start_cell: StartCell) -> CellProcesses:
    """Give a cell that is Held by its worker, with the item in section 2."""
    cell = start_cell(fail=['worker.TASK_A=abort'])
    cell.connect()
    cell.run_small()
    cell.watch.until_held()
    return cell


def test_a_hold_is_shown_and_answered(held_cell: CellProcesses) -> None:
    (hold,) = held_cell.watch.status.holds
    folder = held_cell.folder
    status, output, _ = run_verb(folder, 'status')
    assert status == 0
    assert f'hold {hold.id}: section 2, work (TASK_A) of WO-1/1 at' in output

    wrong = run_verb(folder, 'answer', 'H99', 'retry', '--reason', 'x')
    assert wrong[0] == 1
    assert hold.id in wrong[2]
    assert run_verb(folder, 'answer', hold.id, 'retry')[0] == 2, 'a reason is required'
    assert run_verb(folder, 'answer', hold.id, 'dance', '--reason', 'x')[0] == 2
    status, output, _ = run_verb(
        folder, 'answer', hold.id, 'retry', '--reason', 'gripper cleaned', '--who', 'Ada'
    )
    assert status == 0
    decided = held_cell.watch.until('operator.decided', hold=hold.id)
    assert (decided['answer'], decided['who']) == ('retry', 'Ada')
    assert decided['reason'] == 'gripper cleaned'
    assert held_cell.watch.until_ended('WO-1').packed == 1
    held_cell.stop()


def test_an_item_is_taken_off_the_belt(held_cell: CellProcesses) -> None:
    folder = held_cell.folder
    absent = run_verb(folder, 'remove-item', 'WO-1/9', '--reason', 'x')
    assert absent[0] == 1
    assert 'WO-1/1' in absent[2]
    status, output, _ = run_verb(folder, 'remove-item', 'WO-1/1', '--reason', 'broken')
    assert (status, output) == (0, 'WO-1/1 is off the belt\n')
    assert held_cell.watch.until('item.removed')['how'] == 'by_hand'

    (hold,) = held_cell.watch.status.holds
    assert held_cell.watch.answer(hold.id, 'skip').accepted
    job = held_cell.watch.until_ended('WO-1')
    assert (job.packed, job.missing) == (0, 1)
    held_cell.stop()


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
