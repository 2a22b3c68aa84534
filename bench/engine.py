"""Where the engine's time goes: CPU of its settles, and the rooms of the package it is spent in.

The reference cell in virtual time, so that nothing but the engine, the journal and the virtual
robots is measured. CPU and not wall time, and the least of the rounds: others on the machine cost
time, and never give any back.
"""

from __future__ import annotations

import argparse
import cProfile
import pstats
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from bench.virtual_rows import ROOT
from bt_orchestrator.cli.bootstrap import installed_types
from bt_orchestrator.model.events import Event, TaskStarted
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.ports import EventStore
from bt_orchestrator.script.cell_file import read_cell
from bt_orchestrator.script.script_file import read_script
from bt_orchestrator.sim.simulation import Simulation
from bt_orchestrator.store.memory import MemoryStore
from bt_orchestrator.store.sqlite.store import SqliteStore

PACKAGE = 'bt_orchestrator'


class Cost(NamedTuple):
    """Of one run, by task."""

    settle_us: float
    """CPU of the settles."""
    all_us: float
    """That of the virtual robots and of the clock as well."""
    events: float
    settles: float


class Counts:
    """Counts events. Implements `ports.EventSink`."""

    def __init__(self) -> None:
        self.events = self.tasks = 0

    def publish(self, events: Sequence[Event]) -> None:
        """Take in the next events."""
        self.events += len(events)
        self.tasks += sum(isinstance(event, TaskStarted) for event in events)


def run(items: int, journal: str, profile: cProfile.Profile | None = None) -> Cost:
    """Run one order and return what it cost."""
    types = installed_types()
    cell = read_cell(ROOT / 'config' / 'reference_cell.yaml', types)
    script = read_script(ROOT / 'trees' / 'reference_process.yaml', cell, types)
    counts = Counts()
    with _store(journal) as store:
        simulation = Simulation(cell, types, store, [counts])
        simulation.submit([Job('WO-1', script, items, {'label': 'A7'})])
        if profile is not None:
            profile.enable()
        settles, settled_s = 0, 0.0
        began = time.process_time()
        while simulation.state.jobs and simulation.clock.advance():
            before = time.process_time()
            simulation.orchestrator.settle()
            settled_s += time.process_time() - before
            settles += 1
        all_s = time.process_time() - began
        if profile is not None:
            profile.disable()
        simulation.close()
    tasks = counts.tasks
    return Cost(
        settled_s / tasks * 1e6, all_s / tasks * 1e6, counts.events / tasks, settles / tasks
    )


@contextmanager
def _store(journal: str) -> Iterator[EventStore]:
    if journal == 'memory':
        yield MemoryStore()
        return
    with tempfile.TemporaryDirectory(prefix='bench_') as folder:
        store = SqliteStore(Path(folder, 'journal.sqlite3'), synchronous=journal)
        yield store
        store.close()


def shares(profile: cProfile.Profile) -> list[tuple[str, float]]:
    """Return the share of each module of the package, and of what is not of it, largest first."""
    found: Counter[str] = Counter()
    # The untyped table of pstats: a function, and its calls and seconds without those it calls.
    for (file, _, _), (_, _, own_s, _, _) in pstats.Stats(profile).stats.items():  # type: ignore[attr-defined]
        _, inside, module = file.rpartition(f'/{PACKAGE}/')
        found[module if inside else 'Python and its libraries'] += own_s
    total = sum(found.values())
    return [(name, own_s / total) for name, own_s in found.most_common()]


def main() -> int:
    """Print the costs with each journal, and with --profile the shares."""
    parser = argparse.ArgumentParser(prog='python -m bench.engine', description=__doc__)
    parser.add_argument('--rounds', type=int, default=5)
    parser.add_argument('--items', type=int, default=60)
    parser.add_argument('--profile', action='store_true', help='and the shares of the modules')
    args = parser.parse_args()
    journals = ('memory', 'NORMAL', 'FULL')
    found = [
        {journal: run(args.items, journal) for journal in journals} for _ in range(args.rounds)
    ]
    for journal in journals:
        least = min(one[journal] for one in found)
        print(
            f'{journal:7} settles {least.settle_us:4.0f} us, all {least.all_us:4.0f} us a task; '
            f'{least.events:.1f} events and {least.settles:.1f} settles a task'
        )
    if args.profile:
        profile = cProfile.Profile()
        run(args.items, 'NORMAL', profile)
        for name, share in shares(profile)[:20]:
            print(f'{share:6.1%}  {name}')
    return 0


if __name__ == '__main__':
    sys.exit(main())
