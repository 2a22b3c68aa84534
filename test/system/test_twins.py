"""Two tree nodes of one name (semantics 7.3): one of them has no place there."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from cell_processes import SMALL_CELL
from chaos.truth import journal
from patience import until
from program_process import ProgramProcess

from bt_orchestrator.model import events as e


class Nodes:
    """Tree nodes of one name, in processes of their own, each with a journal."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._cell = folder / 'cell.yaml'
        self._cell.write_text(SMALL_CELL)
        self.started: list[ProgramProcess] = []

    def start(self, name: str) -> ProgramProcess:
        """Start one."""
        words = ['run', '--cell', str(self._cell), '--journal', str(self.journal(name))]
        self.started.append(ProgramProcess(words, self._folder, name))
        return self.started[-1]

    def journal(self, name: str) -> Path:
        return self._folder / f'{name}.sqlite3'

    def verb(self, *words: str) -> ProgramProcess:
        """Run a verb to its end."""
        process = ProgramProcess(words, self._folder, f'verb_{len(self.started)}_{words[0]}')
        process.wait()
        return process

    def twin_holds(self, name: str) -> list[str]:
        """Return what a journal says of twins."""
        raised = (x for x in journal(self.journal(name)) if isinstance(x, e.HoldRaised))
        return [hold.message for hold in raised if hold.reason == 'twin']


@pytest.fixture
def nodes(tmp_path: Path) -> Iterator[Nodes]:
    nodes = Nodes(tmp_path)
    yield nodes
    for node in nodes.started:
        node.kill()


def assert_both_hold(nodes: Nodes, a: ProgramProcess, b: ProgramProcess) -> None:
    """Check that each says where the other one is, and says so to whoever asks."""
    until(lambda: nodes.twin_holds('a') and nodes.twin_holds('b'), 'a hold at both')
    ((of_a,), (of_b,)) = nodes.twin_holds('a'), nodes.twin_holds('b')
    assert f'/bt_orchestrator also runs elsewhere: process {b.pid} on ' in of_a
    assert f'/bt_orchestrator also runs elsewhere: process {a.pid} on ' in of_b
    asked = nodes.verb('status')
    assert ': twin (/bt_orchestrator also runs elsewhere: process ' in asked.output
    until(lambda: are_told(nodes.verb('status'), a, b), 'a client to hear both')


def are_told(asked: ProgramProcess, a: ProgramProcess, b: ProgramProcess) -> bool:
    has_warning = '2 nodes answer as /bt_orchestrator, stop all but one: ' in asked.errors
    return has_warning and all(f'process {node.pid} on ' in asked.errors for node in (a, b))


def test_second_node_with_same_name_refuses_start(nodes: Nodes) -> None:
    a = nodes.start('a')
    a.wait_ready()
    b = nodes.start('b')
    assert b.wait() == 1
    assert f'/bt_orchestrator runs already: process {a.pid} on ' in b.errors
    assert 'with cell small_cell, since ' in b.errors
    assert 'Traceback' not in b.errors
    assert not nodes.journal('b').exists()
    assert nodes.twin_holds('a') == []
    asked = nodes.verb('status')
    assert (asked.wait(), asked.errors) == (0, '')
    assert a.stop() == 0


def test_a_node_that_was_killed_is_no_twin(nodes: Nodes) -> None:
    nodes.start('a').wait_ready()
    nodes.started[-1].kill()
    again = nodes.start('a')
    again.wait_ready()
    asked = nodes.verb('status')
    assert (asked.wait(), asked.errors) == (0, '')
    assert again.stop() == 0
    assert nodes.twin_holds('a') == []


def test_7_3_twins_meeting_later_both_hold_until_resumed(nodes: Nodes) -> None:
    a = nodes.start('a')
    a.wait_ready()
    a.send(signal.SIGSTOP)  # as if its cable were unplugged
    b = nodes.start('b')
    b.wait_ready()
    a.send(signal.SIGCONT)
    assert_both_hold(nodes, a, b)
    assert 'stop all but one: process ' in nodes.verb('doctor', '--node', 'bt_orchestrator').output

    a.kill()
    plain = nodes.verb('cell', 'resume', '--all', '--reason', 'x')
    assert plain.wait() == 1
    assert 'resume --hold 1 --reason WHY' in plain.errors
    assert (
        nodes.verb('cell', 'resume', '--hold', '1', '--reason', 'the other one is gone').wait()
        == 0
    )
    assert b.stop() == 0


def test_7_3_twins_starting_together_do_not_both_run(nodes: Nodes) -> None:
    a, b = nodes.start('a'), nodes.start('b')
    for node in (a, b):
        node.wait_ready_or_end()
    if a.is_running and b.is_running:
        assert_both_hold(nodes, a, b)
    else:
        assert a.is_running or b.is_running, 'one may have been first'
