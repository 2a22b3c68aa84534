"""Setups on a real node: told by a real publisher (5.3), and fewer changes in a queue (6.7)."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest
from cell_processes import ROOT, SMALL_CELL, CellProcesses, StartCell, small_script
from diagnostic_msgs.msg import KeyValue
from worker_state import SAYS_NOTHING

from bt_orchestrator.ros.qos import LATCHED

TELLING_CELL = SMALL_CELL.replace(
    'state: {topic: worker/state, type: std_msgs/msg/String, field: data, ready: [READY]}',
    """state: {topic: worker/state, type: diagnostic_msgs/msg/KeyValue, field: key, ready: [READY]}
    setups: {tool: [x, y]}
    changes: {tool: {task: TASK_C, argument: special_argument_1, reads: value}}""",
)


class ToolTopic:
    """What the worker says of its tool, for as long as a test wants it."""

    def __init__(self, cell: CellProcesses) -> None:
        """Say nothing yet.

        :param cell: made with the fault `SAYS_NOTHING`
        """
        self._cell = cell
        self._publisher = cell.watch.ros.node.create_publisher(KeyValue, '/worker/state', LATCHED)

    def tell(self, tool: str) -> None:
        """Say that it is ready, with a tool."""
        self._publisher.publish(KeyValue(key='READY', value=tool))

    def is_shown(self, tool: str) -> None:
        """Wait until the node shows a tool."""
        self._cell.watch.until_status(
            lambda status: any(
                component.name == 'worker'
                and {setup.key: setup.value for setup in component.setups} == {'tool': tool}
                for component in status.components
            ),
            f'the tool {tool!r}',
        )


def submit(cell: CellProcesses, tool: str, order: str) -> None:
    text = small_script(f'with_{tool}', options=f', setup: {{tool: {tool}}}')
    cell.watch.submit(cell.script(text, f'with_{tool}'), order=order)


def changes(cell: CellProcesses) -> int:
    return len(cell.goals(component='worker', task='TASK_C', event='started'))


def test_5_3_what_the_state_topic_tells_counts(start_cell: StartCell, tmp_path: Path) -> None:
    options = ['--journal', str(tmp_path / 'journal.sqlite3'), '--auto-resume']
    cell = start_cell(cell=TELLING_CELL, fail=[SAYS_NOTHING], run_options=options)
    cell.connect()
    topic = ToolTopic(cell)
    topic.tell('x')
    topic.is_shown('x')
    submit(cell, 'x', 'WO-1')
    assert cell.watch.until_ended('WO-1').packed == 1
    assert changes(cell) == 0, 'the topic tells the tool already'

    # The controller says that it is done, and the topic still tells another tool.
    submit(cell, 'y', 'WO-2')
    hold = cell.watch.until_held()
    assert (hold.task, hold.reason) == ('work', 'setup_missing')
    assert hold.message == 'tool of worker is x; the task needs y'
    begun, failed = (
        cell.watch.until(event, job='WO-2', task=task)['time']
        for event, task in (('task.succeeded', 'worker.tool.y'), ('task.failed', 'work'))
    )
    assert failed - begun >= 5.0, 'it has waited for the topic'
    topic.tell('y')
    topic.is_shown('y')
    assert cell.watch.answer(hold.id, 'change').accepted
    assert cell.watch.until_ended('WO-2').packed == 1
    assert changes(cell) == 1, 'nothing was left to change'

    # What happens while no node runs is told to the next one.
    cell.node.kill()
    topic.tell('worn out')
    cell.start_node()
    cell.node.wait_ready()
    topic.is_shown('worn out')
    cell.stop()


# --- the shipped line with three products -------------------------------------------------------

ORDERS = [ROOT / 'config' / 'orders' / f'wo_500{number}.yaml' for number in range(1, 6)]
PRODUCTS = ROOT / 'trees' / 'three_products'


def simulated(cell: CellProcesses, orders: Sequence[Path]) -> Mapping[str, Any]:
    """Return the figures that `simulate` prints."""
    files = ('--cell', str(cell.cell), '--trees', str(PRODUCTS), '--json')
    status, output, errors = cell.verb('simulate', *map(str, orders), *files)
    assert status == 0, errors
    figures: Mapping[str, Any] = json.loads(output)['forecast']
    return figures


def test_6_7_simulation_confirms_savings_of_proposed_order(start_cell: StartCell) -> None:
    """As a user types it, with the shipped line of three products; then the line does so."""
    text = (ROOT / 'config' / 'three_products_cell.yaml').read_text()
    cell = start_cell(text, run_options=['--no-auto-start', '--trees', str(PRODUCTS)])
    cell.connect()
    status, _, errors = cell.verb('submit', *map(str, ORDERS))
    assert status == 0, errors
    status, output, errors = cell.verb('queue', 'propose', '--json')
    assert status == 0, errors
    proposal = json.loads(output)
    assert proposal['is_best']
    assert proposal['order'] == ['WO-5001', 'WO-5005', 'WO-5003', 'WO-5002', 'WO-5004']

    by_name = {path.stem.upper().replace('_', '-'): path for path in ORDERS}
    now = simulated(cell, ORDERS)
    then = simulated(cell, [by_name[name] for name in proposal['order']])
    assert (now['changeover_s'], then['changeover_s']) == pytest.approx((245.0, 110.0))
    predicted = proposal['changeover_s'], proposal['new_changeover_s']
    assert predicted == pytest.approx((now['changeover_s'], then['changeover_s']))
    ends = [max(entry[key] for entry in proposal['jobs']) for key in ('ends_s', 'new_ends_s')]
    assert ends == pytest.approx([now['total_s'], then['total_s']])

    status, _, errors = cell.verb('queue', 'propose', '--apply', '--reason', 'fewer changes')
    assert status == 0, errors
    for command in ('reset', 'start'):
        assert cell.watch.command(command).accepted, command
    assert cell.watch.until_ended('WO-5004').packed == 4
    changes = [entry['task'] for entry in cell.goals(component='arm', event='started')]
    assert (changes.count('TASK_C'), changes.count('TASK_B')) == (2, 2)
    cell.stop()
