"""The node dies, or does not answer: what clients are told, and what they may send again."""

from __future__ import annotations

import signal
import time
from typing import Any

import pytest
from cell_processes import small_script
from opcua.conftest import StartLine, Tell
from opcua.line import ORDERS, Client, job_order, parameter, states_in


@pytest.mark.long
def test_values_turn_uncertain_without_node_and_order_survives(
    start_line: StartLine, tell: Tell
) -> None:
    line = start_line()
    line.cell.script(small_script())
    mes = line.client('mes')
    mes.do('subscribe', values=['Simple/State', ORDERS])
    order = job_order(
        'WO-1',
        runs=4,
        description=[{'text': 'blue ones', 'locale': 'en'}],
        priority=7,
        parameters=[
            parameter('CustomerOrderNumbers', 'String', ['C-1', 'C-2']),
            parameter('JobName', 'String', 'the first'),
        ],
    )
    assert mes.status('Store', order) == 1
    mes.wait_state('WO-1', 'NotAllowedToStart')
    [stored] = mes.read(ORDERS)[0]

    began = time.monotonic()
    line.cell.node.kill()
    _wait_quality(mes, 'Uncertain', len(mes.lines))
    tell(f'uncertain after {time.monotonic() - began:.1f} s')
    seen = len(mes.lines)
    line.cell.start_node()
    line.cell.node.wait_ready()
    _wait_quality(mes, 'Good', seen)
    assert mes.read(ORDERS)[0] == [stored]

    line.server.process.kill()
    line.cell.kill_and_restart_node()
    seen = len(mes.lines)
    line.server.start()
    line.server.wait_ready()
    mes.wait(lambda news: news.get('of') == ORDERS, 'the list of the new server', seen)
    assert mes.read(ORDERS)[0] == [stored]


@pytest.mark.long
def test_resent_order_with_unknown_answer_runs_once(
    start_line: StartLine,
) -> None:
    line = start_line()
    line.cell.script(small_script())
    mes = line.client('mes')
    mes.do('subscribe', values=[ORDERS])
    line.cell.node.send(signal.SIGSTOP)
    try:
        lost = mes.call('JobOrderControl', 'StoreAndStart', job_order('WO-1'), ['a test'])
        assert lost['status'] in ('BadTimeout', 'BadNoCommunication'), lost
    finally:
        line.cell.node.send(signal.SIGCONT)
    _wait_quality(mes, 'Good', 0)
    again = _until_answered(mes, job_order('WO-1'))
    assert again['outputs'] in ([1], [16]), again  # made now, or before
    mes.wait_state('WO-1', 'Ended')
    assert list(states_in(mes.read(ORDERS)[0])) == ['WO-1']
    line.cell.watch.until_ended('WO-1')
    assert len(line.cell.watch.seen('job.queued', job='WO-1')) == 1


def _until_answered(mes: Client, order: Any) -> Any:
    """Send an order again until the node is there to answer."""
    deadline = time.monotonic() + 60
    while True:
        done = mes.call('JobOrderControl', 'StoreAndStart', order, ['a test'])
        if done['outputs'] or time.monotonic() > deadline:
            return done


def _wait_quality(mes: Client, quality: str, after: int) -> None:
    """Wait until a value has come in this quality."""
    mes.wait(lambda news: str(news.get('status', '')).startswith(quality), quality, after)
