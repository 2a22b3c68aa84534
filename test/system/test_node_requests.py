"""Nothing that a node is asked for can stop it; a refusal says what is wrong."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest
from bt_orchestrator_interfaces.action import RunJob
from bt_orchestrator_interfaces.msg import WorkOrder
from bt_orchestrator_interfaces.srv import (
    AnswerHold,
    GetEvents,
    QueueCommand,
    RemoveItem,
    SubmitOrder,
)
from cell_processes import SMALL_CELL, CellProcesses, StartCell, small_script
from diagnostic_msgs.msg import KeyValue
from node_watcher import WHO, NodeWatcher

from bt_orchestrator.script.keys import LARGEST_WHOLE

PARAMS = """
params:
  label: {type: str}
  weight: {type: float, default: 1.0}
"""

GARBAGE = [
    '',
    ' ',
    '/',
    '..',
    '../../../etc/passwd',
    '/dev/zero',
    '.yaml',
    'é\n\t☃',
    '${x}',
    '%s%n',
]
GARBAGE += ['a' * 100_000, '{"a": [', '\x7f\x01', '-1', 'None']


def assert_alive(cell: CellProcesses, order: str) -> None:
    """Fail unless the node still packs an item."""
    cell.run_small(order=order)
    assert cell.watch.until_ended(order).packed == 1


def refusal(
    watch: NodeWatcher, script: Path | str, params: dict[str, str] | None = None, quantity: int = 1
) -> list[str]:
    """Submit an order that must be refused, and return the findings."""
    response = watch.ask_submit(script, quantity=quantity, params=params)
    assert not response.accepted
    assert not response.job
    assert response.message
    return list(response.findings)


@pytest.mark.long
@pytest.mark.timeout(600)
def test_a_node_answers_whatever_it_is_asked(start_cell: StartCell, tmp_path: Path) -> None:
    """One cell, which is idle again after each step."""
    cell = start_cell(f'{SMALL_CELL}most_items: {LARGEST_WHOLE}\n', fail=['worker.TASK_A#1=abort'])
    cell.connect()
    _holds_and_items_are_answered_with_what_there_is(cell)
    _an_order_that_is_wrong_is_refused_with_every_mistake(cell)
    _an_order_id_is_taken_once(cell)
    _no_file_outside_the_folders_is_read(cell, tmp_path)
    _garbage_in_every_service_is_answered(cell)
    _a_file_that_is_no_script_is_refused(cell)
    _8_2_a_script_that_would_get_stuck_is_refused(cell)
    _what_comes_while_the_node_is_busy_is_all_answered(cell)
    _a_very_large_order_delays_nobody(cell)
    cell.stop()


def _holds_and_items_are_answered_with_what_there_is(cell: CellProcesses) -> None:
    cell.run_small(order='held')
    hold = cell.watch.until_held()

    unknown = cell.watch.answer('H99', 'retry')
    assert (unknown.accepted, hold.id in unknown.message) == (False, True)
    impossible = cell.watch.answer(hold.id, 'dance')
    assert (impossible.accepted, 'retry' in impossible.message) == (False, True)
    absent = cell.watch.remove('held/7')
    assert (absent.accepted, 'held/1' in absent.message) == (False, True)

    assert cell.watch.answer(hold.id, 'retry').accepted
    assert cell.watch.until_ended('held').packed == 1
    assert not cell.watch.answer(hold.id, 'retry').accepted, 'it is answered'


def _an_order_that_is_wrong_is_refused_with_every_mistake(cell: CellProcesses) -> None:
    watch = cell.watch
    wrong = cell.script(small_script(options=', retires: 2').replace('TASK_A', 'TSK_A'))
    misspelt = refusal(watch, wrong)
    assert len(misspelt) >= 4, misspelt
    assert all(finding.startswith(f'{wrong}:') for finding in misspelt)
    assert any('retires' in finding and 'retries' in finding for finding in misspelt)

    (unknown,) = refusal(watch, 'smal')
    assert 'small' in unknown, 'the nearest name is offered'

    path = cell.script(small_script() + PARAMS, 'params')
    (missing,) = refusal(watch, path)
    assert '`label` is missing' in missing
    several = refusal(watch, path, {'lable': 'A7', 'weight': 'heavy'})
    assert any('lable' in finding and 'label' in finding for finding in several)
    assert any('weight' in finding for finding in several)

    (quantity,) = refusal(watch, path, {'label': 'A7'}, quantity=0)
    assert 'quantity' in quantity
    watch.submit(path, order='right', params={'label': 'A7', 'weight': '2.5'})
    assert watch.until_ended('right').packed == 1
    assert watch.until('job.queued', job='right')['params'] == {'label': 'A7', 'weight': 2.5}


def _an_order_id_is_taken_once(cell: CellProcesses) -> None:
    watch = cell.watch
    path = cell.script(small_script())
    watch.submit(path, order='WO-1')
    again = watch.ask_submit(path, order='WO-1')
    assert (again.accepted, 'WO-1' in again.message) == (False, True)
    watch.until_ended('WO-1')
    afterwards = watch.ask_submit(path, order='WO-1')
    assert not afterwards.accepted, 'ended orders keep their ids'

    first, second = (watch.submit(path, order='').job for _ in range(2))
    assert len({first, second, 'WO-1'}) == 3, 'an id is assigned that is free'
    watch.until_ended(second)


def _no_file_outside_the_folders_is_read(cell: CellProcesses, tmp_path: Path) -> None:
    watch = cell.watch
    secret = tmp_path / 'secret.yaml'
    secret.write_text('root: hidden\n')
    os.mkfifo(cell.folder / 'pipe.yaml')
    for path in ('/etc/shadow', '/proc/kmsg', str(secret), '../secret.yaml'):
        (finding,) = refusal(watch, path)
        assert 'is not in a folder of this node' in finding, path
        assert 'hidden' not in finding
    (pipe,) = refusal(watch, 'pipe')
    assert 'there is no script `pipe`' in pipe
    assert_alive(cell, 'after_secrets')


def _garbage_in_every_service_is_answered(cell: CellProcesses) -> None:
    watch = cell.watch
    path = str(cell.script(small_script()))
    before = len(watch.events)
    for text in GARBAGE:
        answer = AnswerHold.Request(hold=text, answer=text, who=text, reason=text)
        assert not watch.call(AnswerHold, 'answer_hold', answer).accepted, text
        removal = RemoveItem.Request(item=text, who=text, reason=text)
        assert not watch.call(RemoveItem, 'remove_item', removal).accepted, text
        assert refusal(watch, text), text
        pairs = [KeyValue(key=text, value=text)]
        order = SubmitOrder.Request(order=text, script=path, quantity=1, params=pairs)
        response = watch.call(SubmitOrder, 'submit_order', order)
        assert not response.accepted, text
        assert response.findings, text
    recorded = {event['event'] for event in watch.events[before:]}
    assert not recorded & {'job.queued', 'operator.decided', 'item.removed'}
    assert_alive(cell, 'after_garbage')


def _a_file_that_is_no_script_is_refused(cell: CellProcesses) -> None:
    watch, folder = cell.watch, cell.folder
    contents = {
        'binary': bytes(range(256)),
        'empty': b'',
        'list': b'- 1\n- 2\n',
        'broken': b'script: [\n',
        'bomb': b'a: &a [x, x]\nb: &b [*a, *a]\nc: [*b, *b]\n',
        'nested': b'[' * 5000,
        'large': b'#' * 5_000_000,
    }
    for name, content in contents.items():
        (folder / f'{name}.yaml').write_bytes(content)
        assert refusal(watch, name), name
    (folder / 'folder.yaml').mkdir()
    assert refusal(watch, 'folder')
    assert_alive(cell, 'after_files')


def _8_2_a_script_that_would_get_stuck_is_refused(cell: CellProcesses) -> None:
    flag = '  - {flag: early, upstream: work, downstream: feed}'
    stuck = cell.script(small_script() + f'lateral_dependencies:\n{flag}\n', 'stuck')
    (finding,) = refusal(cell.watch, stuck)
    assert finding.startswith(f'{stuck}:10:5: the line gets stuck with small')
    assert 'section 1 is waiting for work to set flag early' in finding
    assert finding.endswith('initial count 1 of flag early frees it')
    assert_alive(cell, 'after_stuck')


def _what_comes_while_the_node_is_busy_is_all_answered(cell: CellProcesses) -> None:
    watch, many = cell.watch, 40
    path = str(cell.script(small_script()))
    goal = RunJob.Goal(order=WorkOrder(order='A', script=path, quantity=1))
    asked = [watch.begin(GetEvents, 'get_events', GetEvents.Request())]
    handles = [watch.ros.request(f'{watch.name}/run_job', RunJob, goal)]
    client, actions = watch.client(GetEvents, 'get_events'), watch.ros.client
    os.kill(cell.node.pid, signal.SIGSTOP)
    asked += [client.call_async(GetEvents.Request()) for _ in range(many)]
    handles += [
        actions(f'{watch.name}/run_job', RunJob).send_goal_async(goal) for _ in range(many)
    ]
    os.kill(cell.node.pid, signal.SIGCONT)
    watch.ros.spin_until(lambda: all(call.done() for call in asked), 'all events')
    watch.ros.spin_until(lambda: all(call.done() for call in handles), 'all goals to be answered')
    watch.until_ended('A')


def _a_very_large_order_delays_nobody(cell: CellProcesses) -> None:
    watch, path = cell.watch, cell.script(small_script())
    (finding,) = refusal(watch, path, quantity=LARGEST_WHOLE + 1)
    assert str(LARGEST_WHOLE) in finding

    watch.submit(path, order='large', quantity=LARGEST_WHOLE)
    watch.until('item.removed', count=2, job='large')
    (job,) = (entry for entry in watch.status.jobs if entry.id == 'large')
    assert (job.quantity, job.state) == (LARGEST_WHOLE, 'Running')
    stop = QueueCommand.Request(command='stop', job='large', who=WHO, reason='test')
    assert watch.call(QueueCommand, 'queue/command', stop).accepted
    watch.until('job.completed', job='large')


def test_non_script_file_is_never_quoted(start_cell: StartCell, tmp_path: Path) -> None:
    cell = start_cell(run_options=['--script-paths'])
    cell.connect()
    secret = tmp_path / 'shadow'
    secret.write_text('hunter2:$6$0a1b2c:19700:0:99999:7:::\npassword: hunter2\n')
    (finding,) = refusal(cell.watch, secret)
    assert finding.startswith(f'{secret}:1:1: this is not a script, but ')
    assert not any(word in finding for word in ('hunter2', '0a1b2c', 'password'))
    for path in ('/proc/kmsg', '/dev/zero', '/etc', '/'):
        assert len(refusal(cell.watch, path)) == 1
    assert_alive(cell, 'after_secrets')
    cell.stop()
