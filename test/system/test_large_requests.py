"""While orders are read, the node does everything else; what reads them may end at any moment."""

from __future__ import annotations

import os
import re
import signal
from pathlib import Path
from typing import Any

import pytest
from action_msgs.msg import GoalStatus
from bt_orchestrator_interfaces.action import RunJob
from bt_orchestrator_interfaces.msg import WorkOrder
from bt_orchestrator_interfaces.srv import GetEvents, QueueAdd, QueueUpdate, SubmitOrder
from cell_processes import CellProcesses, runs, small_script

from bt_orchestrator.model.limits import FINDINGS, ORDERS, REQUEST_BYTES
from bt_orchestrator.script.composing import MOST_NODES

LIGHT = 5
"""Questions that are answered while one request is read: one may be in front of it."""

MODULE = 'bt_orchestrator.ros.services.order_process'


def reading_process(cell: CellProcesses) -> int:
    """Return the process that reads the orders of a node, once it is there."""
    return cell.child(MODULE)


def ask_meanwhile(cell: CellProcesses) -> None:
    """Ask the node for other things, one after another."""
    for _ in range(LIGHT):
        assert cell.watch.call(GetEvents, 'get_events', GetEvents.Request()).accepted


def answer(cell: CellProcesses, future: Any) -> Any:
    cell.watch.ros.spin_until(future.done, 'the answer')
    return future.result()


def order(script: Path, name: str = '') -> SubmitOrder.Request:
    return SubmitOrder.Request(script=str(script), order=name, quantity=1)


@pytest.mark.usefixtures('children_by_python')
@pytest.mark.long
@pytest.mark.timeout(600)
def test_large_requests(small_cell: CellProcesses) -> None:
    cell = small_cell
    _others_are_answered_while_a_large_script_is_read(cell)
    _many_mistakes_are_counted_and_some_of_them_told(cell)
    _a_request_that_is_too_large_is_refused_at_once(cell)
    _a_reading_that_is_killed_is_begun_again(cell)
    _a_reading_that_takes_too_long_is_told_and_the_next_one_works(cell)
    _a_goal_that_is_cancelled_while_its_order_is_read_queues_nothing(cell)
    _orders_of_one_request_are_queued_in_one_settle(cell)
    _no_process_is_left_of_a_node_that_is_killed(cell)
    cell.stop()


def _others_are_answered_while_a_large_script_is_read(cell: CellProcesses) -> None:
    stray = ', '.join(['x'] * (MOST_NODES - 100))
    path = cell.script(f'script: wrong\nsections: {{}}\nstray: [{stray}]\n', 'wrong')
    future = cell.watch.begin(SubmitOrder, 'submit_order', order(path))
    ask_meanwhile(cell)
    assert not future.done(), 'the light ones came first'

    reply = answer(cell, future)
    assert not reply.accepted
    cell.run_small(order='meanwhile')
    assert cell.watch.until_ended('meanwhile').packed == 1


def _many_mistakes_are_counted_and_some_of_them_told(cell: CellProcesses) -> None:
    wrong = '\n'.join(f'    - {{task: NONE_{n}, action: feeder/task}}' for n in range(300))
    path = cell.script(f'script: wrong\nsections:\n  1:\n{wrong}\n', 'wrong')
    reply = cell.watch.call(SubmitOrder, 'submit_order', order(path))
    assert len(reply.findings) == FINDINGS + 1
    assert re.fullmatch(r'and 2\d\d more; bt-orchestrator check.*', reply.findings[-1])


def _a_request_that_is_too_large_is_refused_at_once(cell: CellProcesses) -> None:
    watch, path = cell.watch, cell.script(small_script())
    queued = len(watch.seen('job.queued'))
    large = WorkOrder(script=str(path), order='x' * REQUEST_BYTES)
    small = WorkOrder(script=str(path), quantity=1)
    os.kill(reading_process(cell), signal.SIGSTOP)  # nothing is given to it
    for orders, words in (
        ([small, large], 'of text, and a request may have 1000000; nothing was queued'),
        ([small] * (ORDERS + 1), '251 orders are too many for one request'),
    ):
        reply = watch.call(QueueAdd, 'queue/add', QueueAdd.Request(orders=orders))
        assert not reply.accepted
        assert words in reply.message
    words = 'of text, and a request may have 1000000'
    change = QueueUpdate.Request(job='A', reason='why', details='x' * (REQUEST_BYTES + 1))
    reply = watch.call(QueueUpdate, 'queue/update', change)
    assert reply.message.startswith('the orders of this request have 1000001 bytes'), reply.message
    assert words in reply.message
    handle = watch.ros.start(f'{watch.name}/run_job', RunJob, RunJob.Goal(order=large))
    result = watch.ros.result(handle).result
    assert result.exit_status == 'refused'
    assert result.message.startswith('the orders of this request have'), result.message
    assert len(watch.seen('job.queued')) == queued
    os.kill(reading_process(cell), signal.SIGCONT)


def _a_reading_that_is_killed_is_begun_again(cell: CellProcesses) -> None:
    path = cell.script(small_script())
    before = len(cell.watch.seen('job.queued'))
    child = reading_process(cell)
    os.kill(child, signal.SIGSTOP)
    first, second = (
        cell.watch.begin(SubmitOrder, 'submit_order', order(path, name))
        for name in ('first', 'second')
    )
    ask_meanwhile(cell)
    assert not first.done()
    os.kill(child, signal.SIGKILL)
    assert [answer(cell, future).job for future in (first, second)] == ['first', 'second']
    cell.watch.until('job.queued', count=before + 2)
    queued = [event['job'] for event in cell.watch.seen('job.queued')[before:]]
    assert queued == ['first', 'second']
    cell.watch.until_ended('second')


def _a_reading_that_takes_too_long_is_told_and_the_next_one_works(cell: CellProcesses) -> None:
    path = cell.script(small_script())
    cell.watch.submit(path, order='before')  # it is ready
    os.kill(reading_process(cell), signal.SIGSTOP)
    reply = answer(cell, cell.watch.begin(SubmitOrder, 'submit_order', order(path)))
    assert not reply.accepted
    assert 'reading this took longer than' in reply.message
    cell.watch.submit(path, order='after')
    assert cell.watch.until_ended('after').packed == 1


def _a_goal_that_is_cancelled_while_its_order_is_read_queues_nothing(cell: CellProcesses) -> None:
    path = cell.script(small_script())
    watch = cell.watch
    watch.submit(path, order='earlier')  # it is ready
    child = reading_process(cell)
    os.kill(child, signal.SIGSTOP)
    goal = RunJob.Goal(order=WorkOrder(order='A', script=str(path), quantity=1))
    handle = watch.ros.start(f'{watch.name}/run_job', RunJob, goal)
    cancelled = watch.ros.wait(handle.cancel_goal_async(), 'the answer to the cancel request')
    assert len(cancelled.goals_canceling) == 1
    os.kill(child, signal.SIGCONT)
    end = watch.ros.result(handle)
    assert (end.status, end.result.exit_status) == (GoalStatus.STATUS_CANCELED, 'refused')
    assert 'cancelled before its order was queued' in end.result.message
    watch.until_ended('earlier')
    assert not watch.seen('job.queued', job='A')


def _orders_of_one_request_are_queued_in_one_settle(cell: CellProcesses) -> None:
    """They stay in the queue, which ends with the node in the next step."""
    before = len(cell.watch.seen('job.queued'))
    path = cell.script(small_script())
    orders = [WorkOrder(script=str(path), quantity=1)] * ORDERS
    request = QueueAdd.Request(orders=orders, held=True)
    assert cell.watch.call(QueueAdd, 'queue/add', request).accepted
    last = cell.watch.until('job.queued', count=before + ORDERS)
    queued = cell.watch.seen('job.queued')[before:]
    assert [event['job'] for event in queued] == [f'WO-{n}' for n in range(1, ORDERS + 1)]
    assert last['time'] == queued[0]['time']


def _no_process_is_left_of_a_node_that_is_killed(cell: CellProcesses) -> None:
    child = reading_process(cell)
    cell.node.kill()
    cell.watch.ros.spin_until(lambda: not runs(child, MODULE), 'the end of the process')
    cell.start_node()
    cell.node.wait_ready()
