"""The cable between orchestrator and controllers is cut and mended (semantics 9.2, 9.3)."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from cell_processes import SMALL_CELL, SPEED, small_script
from chaos.network import Network, why_not
from chaos.truth import Controllers, journal, judge
from program_process import ProgramProcess

from bt_orchestrator.model import events as e

pytestmark = pytest.mark.skipif(why_not() is not None, reason=str(why_not()))

ITEMS = 3

_LOOK_S = 0.05


class Computers:
    """The tree node on one computer, the controllers on the other."""

    def __init__(self, network: Network, folder: Path) -> None:
        self.network = network
        self.log = folder / 'goals.jsonl'
        self._folder = folder
        self._journal = folder / 'journal.sqlite3'
        cell = folder / 'cell.yaml'
        cell.write_text(SMALL_CELL)
        (folder / 'small.yaml').write_text(small_script(task='TASK_C'))
        words = ['sim-cell', '--cell', str(cell), '--log', str(self.log), '--speed', str(SPEED)]
        self.sim = ProgramProcess(words, folder, 'sim', within=network.within(1))
        words = ['run', '--cell', str(cell), '--trees', str(folder), '--auto-resume']
        # Whoever is on a network may not command a node by itself.
        words += ['--unauthenticated-role', 'mes']
        self._node_words = [*words, '--journal', str(self._journal)]
        self.node = self.start_node()
        self.sim.wait_ready()

    def start_node(self) -> ProgramProcess:
        """Start the tree node, and wait until it can be asked."""
        within = self.network.within(0)
        self.node = ProgramProcess(self._node_words, self._folder, 'node', within=within)
        self.node.wait_ready()
        return self.node

    def submit(self) -> None:
        """Queue the order."""
        order = self._folder / 'order.yaml'
        order.write_text(f'order: WO-1\nscript: small\nquantity: {ITEMS}\n')
        words = ['submit', str(order)]
        within = self.network.within(0)
        verb = ProgramProcess(words, self._folder, 'submit', within=within)
        assert verb.wait() == 0, verb.errors

    def until_works(self, times: int) -> str:
        """Wait until the worker has begun so many goals, and return the last one's UUID."""
        self._until(lambda: len(self._worked('started')) >= times, 'the worker to begin')
        return str(self._worked('started')[times - 1]['goal'])

    def until_done(self, goal: str) -> None:
        """Wait until the controller has ended a goal, whoever knows."""
        self._until(lambda: Controllers(self.log).succeeded(goal), 'the worker to end')

    def until_completed(self) -> list[e.Event]:
        """Wait until the job is complete, and return the journal."""
        self._until(lambda: self._has(e.JobCompleted), 'the end of the job', within_s=90.0)
        return journal(self._journal)

    def close(self) -> None:
        """End everything."""
        self.node.kill()
        self.sim.kill()

    def _worked(self, event: str) -> list[Any]:
        records = Controllers(self.log).records
        return [r for r in records if (r['event'], r['component']) == (event, 'worker')]

    def _has(self, kind: type[e.Event]) -> bool:
        return any(isinstance(event, kind) for event in journal(self._journal))

    def _until(self, condition: Callable[[], bool], what: str, within_s: float = 60.0) -> None:
        deadline = time.monotonic() + within_s
        while not condition():
            assert time.monotonic() < deadline, f'waited {within_s:g} s for {what}'
            assert self.node.is_running, self.node.errors
            time.sleep(_LOOK_S)


@pytest.fixture
def computers(tmp_path: Path) -> Iterator[Computers]:
    network = Network()
    try:
        computers = Computers(network, tmp_path)
        yield computers
        computers.close()
    finally:
        network.close()


def assert_nothing_lost(events: list[e.Event], computers: Computers) -> None:
    assert judge(events, Controllers(computers.log), {}).faults == []
    assert not [x for x in events if isinstance(x, e.TaskFailed)]
    packed = [x.item for x in events if isinstance(x, e.ItemRemoved) and x.how == 'packed']
    assert packed == [f'WO-1/{n}' for n in range(1, ITEMS + 1)]


def test_9_3_goal_end_during_cable_cut_is_received(computers: Computers) -> None:
    computers.submit()
    goal = computers.until_works(2)
    computers.network.cut()
    computers.until_done(goal)
    computers.network.mend()
    assert_nothing_lost(computers.until_completed(), computers)


def test_9_2_orchestrator_restarted_without_network_takes_over(
    computers: Computers,
) -> None:
    computers.submit()
    computers.until_works(2)
    computers.network.cut()
    computers.node.kill()
    computers.start_node()
    computers.network.mend()
    events = computers.until_completed()
    assert_nothing_lost(events, computers)
    assert any(isinstance(x, e.TaskAdopted) for x in events)
