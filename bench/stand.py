"""The stand: simulated servers in a process of their own, and the drivers that take turns."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from bt_orchestrator_interfaces.srv import SubmitOrder
from program_process import ProgramProcess
from ros_domain import take_free_domain

from bench.line_files import SECTIONS, cell_text, script_text
from bt_orchestrator.ros.client import NodeClient

TASKS_A_CYCLE = 10
PATIENCE_S = 60.0
_TICKS_A_SECOND = os.sysconf('SC_CLK_TCK')
_PAGE = os.sysconf('SC_PAGE_SIZE')


class Measured(NamedTuple):
    """What one driver did in one round. All in seconds."""

    sequence: list[float]
    """From the end of a section's first task to the arrival of its second."""
    wrap: list[float]
    """From the end of the belt's move to the arrival of the first goal of the next cycle."""
    cpu_per_task: float


class Stand:
    """Servers for a line of five sections, and a folder on an ordinary disk."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.cell = folder / 'cell.yaml'
        self.cell.write_text(cell_text(SECTIONS))
        self.script = folder / 'line.yaml'
        self.script.write_text(script_text(SECTIONS))
        self.log = folder / 'goals.jsonl'
        self._number = 0
        words = ['sim-cell', '--cell', str(self.cell), '--log', str(self.log)]
        self._servers = ProgramProcess(words, folder, 'servers')
        self._servers.wait_ready()

    def close(self) -> None:
        """End the servers."""
        self._servers.stop()

    def name(self, kind: str) -> str:
        """Return a name that was not used before."""
        self._number += 1
        return f'{kind}_{self._number}'

    def records(self, offset: int) -> list[dict[str, Any]]:
        """Return what the servers wrote behind a place in their log."""
        with self.log.open() as file:
            file.seek(offset)
            return [json.loads(line) for line in file if line.endswith('\n')]

    def until_ended(self, offset: int, tasks: int, patience_s: float = PATIENCE_S) -> None:
        """Wait for so many ends of tasks, the belt's left out."""
        until(lambda: self._ended(offset) >= tasks, f'{tasks} tasks', patience_s)

    def _ended(self, offset: int) -> int:
        ended = [r for r in self.records(offset) if r['event'] == 'ended']
        return sum(1 for record in ended if record['component'] != 'conveyor')

    def by_hand(self, module: str, option: str, cycles: int) -> Measured:
        """Let one of the programs beside this one drive the line."""
        command = [sys.executable, '-m', f'bench.{module}', option, str(cycles)]
        process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        assert process.stdin is not None
        assert process.stdout is not None
        with process:
            process.stdout.readline()
            offset, before_s = self.log.stat().st_size, cpu_s(process.pid)
            print(file=process.stdin, flush=True)
            assert process.stdout.readline() == 'done\n'
            used_s = cpu_s(process.pid) - before_s
        return self._measured(offset, used_s)

    def ours(
        self, cycles: int, synchronous: str, executor: str, watched: bool = False
    ) -> Measured:
        """Let a tree node drive the line, which has run one item before."""
        journal = self.folder / f'{self.name("journal")}.sqlite3'
        options = ['--journal', str(journal), '--journal-synchronous', synchronous]
        with self.node([*options, '--executor', executor]) as node, watcher(watched):
            offset = self.log.stat().st_size
            self.submit('WARM', 1)
            self.until_ended(offset, TASKS_A_CYCLE)
            offset, before_s = self.log.stat().st_size, cpu_s(node.pid)
            self.submit('WO-1', cycles)
            self.until_ended(offset, TASKS_A_CYCLE * cycles)
            return self._measured(offset, cpu_s(node.pid) - before_s)

    @contextmanager
    def node(self, options: Sequence[str], cell: Path | None = None) -> Iterator[ProgramProcess]:
        """Run a tree node."""
        words = ['run', '--cell', str(cell or self.cell), *options]
        process = ProgramProcess(words, self.folder, self.name('node'))
        try:
            process.wait_ready()
            yield process
        finally:
            process.stop()

    def submit(self, order: str, quantity: int, script: Path | None = None) -> None:
        """Give the tree node an order."""
        request = SubmitOrder.Request(
            order=order, script=str(script or self.script), quantity=quantity
        )
        with NodeClient('/bt_orchestrator', PATIENCE_S) as client:
            answer = client.call(SubmitOrder, 'submit_order', request)
        assert answer.accepted, [answer.message, *answer.findings]

    def _measured(self, offset: int, used_s: float) -> Measured:
        records = self.records(offset)
        tasks = self._ended(offset)
        return Measured(list(_sequences(records)), list(_wraps(records)), used_s / tasks)


@contextmanager
def stand() -> Iterator[Stand]:
    """Set up a stand in a ROS domain of its own."""
    domain, lock = take_free_domain()
    os.environ['ROS_DOMAIN_ID'] = str(domain)
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    with lock, tempfile.TemporaryDirectory(prefix='bench_', dir='/var/tmp') as folder:
        one = Stand(Path(folder))
        try:
            yield one
        finally:
            one.close()


@contextmanager
def watcher(attached: bool) -> Iterator[None]:
    """Have a tree watcher attached, in a process of its own."""
    if not attached:
        yield
        return
    program = Path(__file__).parents[1] / 'test' / 'watching_client.py'
    process = subprocess.Popen([sys.executable, str(program)], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    try:
        assert process.stdout.readline().startswith('watching: ')
        yield
    finally:
        process.kill()
        process.wait()
        process.stdout.close()


def until(condition: Callable[[], bool], what: str, patience_s: float = PATIENCE_S) -> None:
    """Look at a condition until it holds."""
    deadline = time.monotonic() + patience_s
    while not condition():
        if time.monotonic() > deadline:
            raise TimeoutError(f'waited {patience_s:g} s for {what}')
        time.sleep(0.2)


def cpu_s(pid: int) -> float:
    """Return the CPU seconds that a process has used."""
    fields = Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / _TICKS_A_SECOND


def memory_mb(pid: int) -> float:
    """Return the resident memory of a process."""
    return int(Path(f'/proc/{pid}/statm').read_text().split()[1]) * _PAGE / 1e6


def _sequences(records: Sequence[dict[str, Any]]) -> Iterator[float]:
    ended: dict[str, float] = {}
    for record in records:
        component = record['component']
        if record['event'] == 'ended' and component[0] == 'a':
            ended[component[1:]] = record['time']
        elif record['event'] == 'accepted' and component[0] == 'b' and component[1:] in ended:
            yield record['time'] - ended.pop(component[1:])


def _wraps(records: Sequence[dict[str, Any]]) -> Iterator[float]:
    moved: float | None = None
    for record in records:
        if record['component'] == 'conveyor':
            moved = record['time'] if record['event'] == 'ended' else None
        elif record['event'] == 'accepted' and moved is not None:
            yield record['time'] - moved
            moved = None
