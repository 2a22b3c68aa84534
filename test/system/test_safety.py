"""The safety input of a real line, published by processes that are killed, silent or doubled."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest
import safety_publisher
from cell_processes import SMALL_CELL, CellProcesses, StartCell, run_verb
from fakes.who_may import differences
from patience import PATIENCE_S
from program_process import ProgramProcess

from bt_orchestrator.model.by import By, Known, Role
from bt_orchestrator.model.jobs.order import WorkOrder
from bt_orchestrator.model.requests import ask
from bt_orchestrator.ros.link.ros_link import RosLink
from bt_orchestrator.script.users.file import UsersFile
from bt_orchestrator.script.users.keys import Key, SigningKey

CELL = f"""{SMALL_CELL}
safety: {{topic: /safety/ok, type: std_msgs/msg/Bool, field: data, ready: [true], within: 4.0}}
"""
LATE = ['worker.TASK_C#1=late:1200']
"""The goal runs for a minute, unless it is cancelled."""


class Safety:
    """The safety controllers of a test."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._value = folder / 'safety.txt'
        self.processes: list[ProgramProcess] = []
        self.says('true')
        self.start()

    def start(self) -> ProgramProcess:
        """Start one more."""
        name = f'safety_{len(self.processes)}'
        program = [safety_publisher.__file__]
        self.processes.append(
            ProgramProcess([str(self._value)], self._folder, name, program, cwd=self._folder)
        )
        self.processes[-1].wait_ready()
        return self.processes[-1]

    def says(self, value: str) -> None:
        """Set what all of them say from now on."""
        fresh = self._value.with_suffix('.new')
        fresh.write_text(value)
        fresh.replace(self._value)

    def freeze(self) -> None:
        """Stop the first one, as a computer that hangs."""
        os.kill(self.processes[0].pid, signal.SIGSTOP)

    def close(self) -> None:
        """Leave nothing behind."""
        for process in self.processes:
            process.kill()


@pytest.fixture
def safety(tmp_path: Path) -> Iterator[Safety]:
    publisher = Safety(tmp_path)
    yield publisher
    publisher.close()


def at_work(start_cell: StartCell, *options: str) -> CellProcesses:
    """Start a line, and wait until its long goal runs."""
    cell = start_cell(CELL, fail=LATE, sim_options=['--no-safety'], run_options=[*options])
    cell.connect()
    cell.watch.until_status(lambda view: view.safety == 'ready', 'the safety input')
    cell.run_small(task='TASK_C', quantity=2)
    cell.watch.ros.spin_until(lambda: cell.goals(event='started', component='worker'), 'the goal')
    return cell


def until_safety(cell: CellProcesses, wanted: str) -> None:
    """Wait until the status says this of the safety input."""
    cell.watch.until_status(lambda status: status.safety == wanted, wanted)


def flap(safety: Safety, cell: CellProcesses) -> None:
    """Let the input come and go several times, each time for long enough to be seen."""
    for value in ('false', 'true', 'false', 'true', 'false'):
        safety.says(value)
        wanted = 'ready' if value == 'true' else 'its value is False'
        until_safety(cell, wanted)


LOSSES: dict[str, tuple[Callable[[Safety, CellProcesses], object], str]] = {
    'lost': (lambda safety, _: safety.processes[0].kill(), 'no message for 4 s'),
    'frozen': (lambda safety, _: safety.freeze(), 'no message for 4 s'),
    'silent': (lambda safety, _: safety.says(''), 'no message for 4 s'),
    'false': (lambda safety, _: safety.says('false'), 'its value is False'),
    'flapping': (flap, 'its value is False'),
    'doubled': (lambda safety, _: safety.start(), 'it has 2 publishers: /safety_controller'),
}


@pytest.mark.parametrize('loss', LOSSES)
@pytest.mark.long
def test_7_9_loss_ends_goals_once_and_return_starts_nothing(
    start_cell: StartCell, safety: Safety, loss: str
) -> None:
    cell = at_work(start_cell)
    lose, why = LOSSES[loss]
    lose(safety, cell)
    cell.watch.until_state('Aborted')
    cell.watch.ros.spin_until(lambda: cell.goals(event='ended', component='worker'), 'its end')
    (ended,) = cell.goals(event='ended', component='worker')
    assert ended['status'] == 'canceled'
    (aborting,) = cell.watch.seen('cell.state_changed', state='Aborting')
    assert aborting['reason'].startswith('the safety input is not ready: ')
    assert why in cell.watch.seen('safety.changed', ready=False)[-1]['reason']
    status, _, errors = run_verb(
        cell.folder, 'cell', 'clear', '--as-shown', str(cell.watch.status.seq), '--reason', 'x'
    )
    assert (status, 'the safety input is not ready' in errors) == (1, True), errors

    for process in safety.processes:
        process.kill()
    safety.says('true')
    safety.processes.clear()
    safety.start()
    cell.watch.until_status(lambda view: view.safety == 'ready', 'the return of the safety input')
    started = len(cell.goals(event='started'))
    cell.watch.ros.spin_for(1.5)
    assert cell.watch.status.state == 'Aborted'
    assert len(cell.goals(event='started')) == started
    assert len(cell.watch.seen('cell.state_changed', state='Aborting')) == 1
    cell.stop(node_status=1)  # it names the goals in doubt


@pytest.mark.parametrize('is_there', [True, False], ids=['there', 'away'])
def test_7_9_take_over_needs_live_safety_input(
    start_cell: StartCell, safety: Safety, is_there: bool, tmp_path: Path
) -> None:
    journal = ['--journal', str(tmp_path / 'journal.db'), '--auto-resume']
    cell = at_work(start_cell, *journal)
    cell.node.kill()
    if not is_there:
        safety.processes[0].kill()
    cell.start_node()
    cell.node.wait_ready()
    if is_there:
        cell.watch.until('task.adopted', task='work')
        cell.watch.until_status(lambda view: view.safety == 'ready', 'the safety input')
        assert cell.goals(event='ended', component='worker') == []
        assert cell.watch.status.state == 'Execute'
    else:
        cell.watch.until_state('Aborted')
        assert len(cell.watch.seen('cell.state_changed', state='Aborting')) == 1
        (ended,) = cell.goals(event='ended', component='worker')
        assert ended['status'] == 'canceled'
    cell.stop(node_status=0 if is_there else 1)


def test_7_9_unsafe_idle_line_is_held_until_resumed(start_cell: StartCell, safety: Safety) -> None:
    cell = start_cell(CELL, sim_options=['--no-safety'])
    cell.connect()
    cell.watch.until_status(lambda shown: shown.safety == 'ready', 'the safety input')
    safety.says('false')
    (hold,) = cell.watch.until_status(lambda shown: shown.holds, 'a hold').holds
    assert (hold.reason, hold.message) == (
        'safety',
        'the safety input is not ready: its value is False',
    )
    cell.run_small()
    _, output, _ = run_verb(cell.folder, 'status')
    assert 'safety input not ready: its value is False' in output
    resume = ('cell', 'resume', '--hold', hold.id, '--reason', 'looked')
    assert run_verb(cell.folder, *resume)[0] == 1
    words = cell.watch.status.safety_words
    assert (words.kind, [shown.value for shown in words.values]) == ('unsafe_value', ['False'])
    safety.says('true')
    cell.watch.until_status(lambda shown: shown.safety == 'ready', 'the return')
    assert cell.watch.status.safety_words.kind == ''
    assert cell.goals(event='started') == []
    assert run_verb(cell.folder, *resume)[0] == 0
    assert cell.watch.until_ended('WO-1').packed == 1
    cell.stop()


@pytest.mark.parametrize('is_signed', [False, True], ids=['trusted', 'signed'])
@pytest.mark.long
def test_7_8_1_ros_requests_match_hand_written_table(
    start_cell: StartCell, safety: Safety, tmp_path: Path, is_signed: bool
) -> None:
    users = UsersFile(tmp_path / 'users.yaml')
    users.change_panel('address', '10.0.0.9', named=True)
    key = SigningKey.made(tmp_path / 'door.pem') if is_signed else None
    if key is not None:
        users.add_key('door', Key(Role.ENGINEER, key.public, 'opcua'))
    believed = ['--signed-commands', 'required'] if is_signed else ['--trust-local-doors']
    options = [*believed, '--users', str(tmp_path / 'users.yaml')]
    cell = start_cell(CELL, sim_options=['--no-safety'], run_options=options)
    cell.connect()
    cell.watch.until_status(lambda view: view.safety == 'ready', 'the safety input')
    with RosLink('/bt_orchestrator', PATIENCE_S, key=key) as link:
        sent = 0

        def told(name: str, by: By, given: Mapping[str, Any]) -> str:
            if name == 'queue.add':
                given = {'orders': [WorkOrder('none', 'W-1', 1)]}
            return link.ask(ask(name, by, **given)).message

        def asked(name: str, given: Mapping[str, Any], role: Role, is_panel: bool) -> str:
            nonlocal sent
            sent += 1  # a sender of its own: else their number would be limited
            known = Known.OPC_UA_PANEL if is_panel else Known.OPC_UA_USER
            return told(name, By(f'{role.value} {sent}', 'a door', 'why', role, known), given)

        def hand_over(wanted: str) -> None:
            reply = asked(f'cell.{wanted}', {}, Role.ENGINEER, True)
            assert reply.startswith(f'the line is in {wanted}'), reply

        def lose() -> None:
            safety.says('false')
            cell.watch.until_status(lambda view: view.safety == 'its value is False', 'the loss')

        began = time.monotonic()
        assert list(differences(asked, hand_over, lose)) == []
        assert time.monotonic() - began < 2 * PATIENCE_S
        # Whoever claims to be at a panel, without a door that is believed, is at none.
        hand_over('local')
        reply = told('cell.reset', By('Eve', 'over there', 'why', Role.ENGINEER, Known.ROS), {})
        unsigned = 'somebody who claims to be Eve (ros unauthenticated) is at none'
        assert ('asks for its users alone' if is_signed else unsigned) in reply
    cell.stop()
