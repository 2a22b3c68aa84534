"""The engine alone: CPU of its settles, and the rooms of the package that use it.

The reference cell in virtual time: only the engine, the journal and the virtual robots work. The
program runs on the package of any revision, so it imports nothing of the bench, and tries each
place in which a class has been.
"""

from __future__ import annotations

import argparse
import cProfile
import gc
import json
import pstats
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path
from types import FrameType
from typing import Any, NamedTuple

from bt_orchestrator.cli.bootstrap import installed_types
from bt_orchestrator.model.events import TaskStarted
from bt_orchestrator.script.cell_file import read_cell
from bt_orchestrator.script.script_file import read_script
from bt_orchestrator.sim.simulation import Simulation
from bt_orchestrator.store.memory import MemoryStore

PACKAGE = 'bt_orchestrator'
ROOT = Path(__file__).parents[1]


def _moved(name: str, *modules: str) -> Any:
    """Return a class from the first module that has it."""
    for module in modules:
        with suppress(ModuleNotFoundError, AttributeError):
            return getattr(import_module(f'{PACKAGE}.{module}'), name)
    raise ImportError(f'{name}: not in {", ".join(modules)}')


Job = _moved('Job', 'model.jobs.order', 'model.order')
SqliteStore = _moved('SqliteStore', 'store.sqlite.store', 'store.sqlite')


class Cost(NamedTuple):
    """Cost of one task in a run."""

    settle_us: float
    """CPU of the settles."""
    all_us: float
    """That of the virtual robots and of the clock as well."""
    events: float
    settles: float
    bytecodes: float = 0.0
    """Instructions of the interpreter, if they were counted: equal in each run."""


class Counts:
    """Counts events. Implements `ports.EventSink`."""

    def __init__(self) -> None:
        self.events = self.tasks = 0

    def publish(self, events: Sequence[object]) -> None:
        """Take in the next events."""
        self.events += len(events)
        self.tasks += sum(isinstance(event, TaskStarted) for event in events)


class Bytecodes:
    """Counts instructions of the interpreter: no load of the machine changes their number."""

    count = 0

    def enable(self) -> None:
        """Count from now on."""
        sys.settrace(self._trace)

    def disable(self) -> None:
        """Count no longer."""
        sys.settrace(None)

    def _trace(self, frame: FrameType, event: str, _: object) -> Any:
        frame.f_trace_opcodes, frame.f_trace_lines = True, False
        self.count += event == 'opcode'
        return self._trace


class Engine:
    """The reference cell and one script, read once."""

    def __init__(self, files: Path = ROOT) -> None:
        self._types = installed_types()
        self._cell = read_cell(files / 'config' / 'reference_cell.yaml', self._types)
        file = files / 'trees' / 'reference_process.yaml'
        self._script = read_script(file, self._cell, self._types)

    def run(
        self, items: int, journal: str, observer: cProfile.Profile | Bytecodes | None = None
    ) -> Cost:
        """Run one order and return its cost."""
        counts = Counts()
        with _store(journal) as store:
            simulation = Simulation(self._cell, self._types, store, [counts])
            simulation.submit([Job('WO-1', self._script, items, {'label': 'A7'})])
            gc.collect()
            if observer is not None:
                observer.enable()
            settles, settled_s = 0, 0.0
            began = time.process_time()
            while simulation.state.jobs and simulation.clock.advance():
                before = time.process_time()
                simulation.orchestrator.settle()
                settled_s += time.process_time() - before
                settles += 1
            all_s = time.process_time() - began
            if observer is not None:
                observer.disable()
            simulation.close()
        tasks = counts.tasks
        bytecodes = observer.count if isinstance(observer, Bytecodes) else 0
        us = 1e6 / tasks
        return Cost(
            settled_s * us, all_s * us, counts.events / tasks, settles / tasks, bytecodes / tasks
        )


@contextmanager
def _store(journal: str) -> Iterator[Any]:
    if journal == 'memory':
        yield MemoryStore()
        return
    with tempfile.TemporaryDirectory(prefix='bench_') as folder:
        store = SqliteStore(Path(folder, 'journal.sqlite3'), synchronous=journal)
        yield store
        store.close()


def shares(profile: cProfile.Profile) -> list[tuple[str, float]]:
    """Return the share of each module of the package, and of what is not of it, largest first."""
    seconds: Counter[str] = Counter()
    # The untyped table of pstats: a function, and its calls and seconds without those it calls.
    for (file, _, _), (_, _, own_s, _, _) in pstats.Stats(profile).stats.items():  # type: ignore[attr-defined]
        _, inside, module = file.rpartition(f'/{PACKAGE}/')
        seconds[module if inside else 'Python and its libraries'] += own_s
    total = sum(seconds.values())
    return [(name, own_s / total) for name, own_s in seconds.most_common()]


def serve(engine: Engine) -> None:
    """Run an order for each line of standard input; print its cost as JSON."""
    for line in sys.stdin:
        journal, items, *count = line.split()
        cost = engine.run(int(items), journal, Bytecodes() if count else None)
        print(json.dumps(cost._asdict()), flush=True)


def main() -> int:
    """Print the costs with each journal, and with --profile the shares."""
    parser = argparse.ArgumentParser(prog='python -m bench.engine', description=__doc__)
    parser.add_argument('--rounds', type=int, default=5)
    parser.add_argument('--items', type=int, default=60)
    parser.add_argument('--profile', action='store_true', help='and the shares of the modules')
    parser.add_argument('--files', type=Path, default=ROOT, help='folder of config and trees')
    parser.add_argument('--serve', action='store_true', help='one run for each line of input')
    args = parser.parse_args()
    engine = Engine(args.files)
    if args.serve:
        serve(engine)
        return 0
    journals = ('memory', 'NORMAL', 'FULL')
    costs = [
        {journal: engine.run(args.items, journal) for journal in journals}
        for _ in range(args.rounds)
    ]
    for journal in journals:
        least = min(cost[journal] for cost in costs)
        print(
            f'{journal:7} settles {least.settle_us:4.0f} us, all {least.all_us:4.0f} us a task; '
            f'{least.events:.1f} events and {least.settles:.1f} settles a task'
        )
    if args.profile:
        profile = cProfile.Profile()
        engine.run(args.items, 'NORMAL', profile)
        for name, share in shares(profile)[:20]:
            print(f'{share:6.1%}  {name}')
    return 0


if __name__ == '__main__':
    sys.exit(main())
