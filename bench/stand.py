"""The stand: simulated servers in a process of their own, and the drivers that take turns."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from threading import Event
from typing import Any, NamedTuple

from bt_orchestrator_interfaces.srv import SubmitOrder
from process_use import family_cpu_s
from program_process import ProgramProcess
from ros_domain import OwnDomain

from bench.line_files import SECTIONS, cell_text, script_text
from bench.rows import percentile
from bench.tail import PATIENCE_S, Tail, until
from bt_orchestrator.model.cell import MOST_ITEMS
from bt_orchestrator.ros.link.client import NodeClient

TASKS_A_CYCLE = 10
WARM_UP = 5
"""Cycles before a measurement: connections, caches, and the admission of the order."""

ENDLESS = MOST_ITEMS
"""Items of an order: more than are made."""


Attached = Callable[[], AbstractContextManager[object]]
"""Begins something that looks on at the node, and ends it with the block."""


class Measured(NamedTuple):
    """What one driver did in one round. All in seconds."""

    sequence: list[float]
    """From the end of a section's first task to the arrival of its second."""
    wrap: list[float]
    """From the end of the belt's move to the arrival of the first goal of the next cycle."""
    cpu_per_task: float
    """Of the driver and the processes it has started, the forecast's among them."""
    made: int = 0
    """Recipes whose scripts were generated meanwhile."""


class Stand:
    """Servers for a line of five sections, and a folder on an ordinary disk."""

    def __init__(self, folder: Path, cell: str) -> None:
        self.folder = folder
        self.cell = folder / 'cell.yaml'
        self.cell.write_text(cell)
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

    def tail(self) -> Tail:
        """Return what reads the log from here on."""
        return Tail(self.log)

    def by_hand(self, module: str, option: str, cycles: int) -> Measured:
        """Let one of the programs beside this one drive the line."""
        command = [sys.executable, '-m', f'bench.{module}', option, str(WARM_UP + cycles)]
        process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        assert process.stdin is not None
        assert process.stdout is not None
        with process:
            try:
                process.stdout.readline()
                tail = self.tail()
                print(file=process.stdin, flush=True)
                measured = _measure(tail, process.pid, cycles)
                assert process.stdout.readline() == 'done\n'
            except BaseException:
                process.kill()  # without its servers it would wait for ever
                raise
        return measured

    def ours(
        self,
        cycles: int,
        synchronous: str,
        executor: str,
        *,
        attached: Attached = nullcontext,
        options: Sequence[str] = (),
        recipes: Iterator[str] | None = None,
        program: str = 'bt_orchestrator',
        journal: str = '',
    ) -> Measured:
        """Let a tree node drive the line.

        :param attached: what looks on as long as the line is driven
        :param options: of `run`, more than those of the journal and the executor
        :param recipes: what is ordered meanwhile, one after another; None: nothing
        :param program: the module that Python runs
        :param journal: its address; empty: a new file
        """
        journal = journal or str(self.folder / f'{self.name("journal")}.sqlite3')
        words = ['--journal', journal, '--journal-synchronous', synchronous]
        words += ['--executor', executor, *options]
        with self.node(words, program) as node, attached():
            tail = self.tail()
            self.submit('WO-1', WARM_UP + cycles if recipes is None else ENDLESS)
            tail.until_ended(WARM_UP * TASKS_A_CYCLE)
            with self._ordering(recipes) as made:
                if recipes is not None:
                    until(lambda: bool(made), 'the first script of a recipe')
                    tail.until_ended(0)  # reads what was done until then
                before = len(made)
                begun = -(-tail.ended // TASKS_A_CYCLE) if recipes is not None else WARM_UP
                measured = _measure(tail, node.pid, cycles, begun)
                return measured._replace(made=len(made) - before)

    @contextmanager
    def _ordering(self, recipes: Iterator[str] | None) -> Iterator[list[str]]:
        """Order by one recipe after another; the list has those whose scripts were made."""
        made: list[str] = []
        is_over = Event()

        def order(recipes: Iterator[str]) -> None:
            while not is_over.is_set():
                recipe = next(recipes)
                self.submit_recipe(recipe)
                made.append(recipe)

        with ThreadPoolExecutor(1) as orders:
            done = orders.submit(order, recipes) if recipes is not None else None
            try:
                yield made
            finally:
                is_over.set()
            if done is not None:
                done.result()  # what went wrong there

    @contextmanager
    def node(
        self, options: Sequence[str], program: str = 'bt_orchestrator'
    ) -> Iterator[ProgramProcess]:
        """Run a tree node.

        :param program: the module that Python runs
        """
        words = ['run', '--cell', str(self.cell), '--trees', str(self.folder)]
        words += ['--recipes', str(self.folder), *options]
        process = ProgramProcess(words, self.folder, self.name('node'), ('-m', program))
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
        _ask(request)

    def submit_recipe(self, recipe: str) -> None:
        """Give the tree node an order by recipe, which nobody has released."""
        _ask(SubmitOrder.Request(recipes=[recipe], quantity=1))


def _ask(request: Any) -> None:
    with NodeClient('/bt_orchestrator', PATIENCE_S) as client:
        answer = client.call(SubmitOrder, 'submit_order', request)
    assert answer.accepted, [answer.message, *answer.findings]


def _measure(tail: Tail, pid: int, cycles: int, begun: int = WARM_UP) -> Measured:
    """Measure what a driver does after its first cycles, in which the order is taken in too.

    :param begun: how many cycles come before
    """
    tail.until_ended(begun * TASKS_A_CYCLE)
    before_s, tasks, first = family_cpu_s(pid), tail.ended, len(tail.records)
    tail.until_ended((begun + cycles) * TASKS_A_CYCLE, PATIENCE_S + cycles)
    used_s, tasks = family_cpu_s(pid) - before_s, tail.ended - tasks
    records = tail.records[first:]
    return Measured(list(sequences(records)), list(_wraps(records)), used_s / tasks)


@contextmanager
def stand(cell: str = '') -> Iterator[Stand]:
    """Set up a stand in a ROS domain of its own.

    :param cell: text of its cell, if it is not the usual one
    """
    with OwnDomain(), tempfile.TemporaryDirectory(prefix='bench_', dir='/var/tmp') as folder:
        new_stand = Stand(Path(folder), cell or cell_text(SECTIONS))
        try:
            yield new_stand
        finally:
            new_stand.close()


@contextmanager
def watcher() -> Iterator[None]:
    """Have a tree watcher attached, in a process of its own."""
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


def in_turns(drives: Mapping[str, Callable[[], Measured]], number: int) -> dict[str, Measured]:
    """Let every candidate drive once; each round begins with another one.

    :param number: of the round
    """
    first = number % len(drives)
    names = [*drives][first:] + [*drives][:first]
    measured = {name: drives[name]() for name in names}
    return {name: measured[name] for name in drives}


class Ratios:
    """Ratios of two candidates, one a round."""

    def __init__(self, rounds: Sequence[Mapping[str, Measured]]) -> None:
        self._rounds = rounds

    def sequence(self, above: str, below: str) -> list[float]:
        """Of the medians of dispatch latencies within a section."""
        return [p50(r[above].sequence) / p50(r[below].sequence) for r in self._rounds]

    def wrap(self, above: str, below: str) -> list[float]:
        """Of the medians of those at the beginning of a cycle."""
        return [p50(r[above].wrap) / p50(r[below].wrap) for r in self._rounds]

    def cpu(self, above: str, below: str) -> list[float]:
        """Of CPU a task."""
        return [r[above].cpu_per_task / r[below].cpu_per_task for r in self._rounds]


def p50(values: Sequence[float]) -> float:
    """Return the median."""
    return percentile(values, 0.5)


def sequences(records: Sequence[dict[str, Any]]) -> Iterator[float]:
    """Yield the times from the end of a section's first task to the arrival of its second."""
    ended: dict[str, float] = {}
    for record in records:
        component = record['component']
        if record['event'] == 'ended' and component[0] == 'a':
            ended[component[1:]] = record['steady']
        elif record['event'] == 'accepted' and component[0] == 'b' and component[1:] in ended:
            yield record['steady'] - ended.pop(component[1:])


def _wraps(records: Sequence[dict[str, Any]]) -> Iterator[float]:
    moved: float | None = None
    for record in records:
        if record['component'] == 'conveyor':
            moved = record['steady'] if record['event'] == 'ended' else None
        elif record['event'] == 'accepted' and moved is not None:
            yield record['steady'] - moved
            moved = None
