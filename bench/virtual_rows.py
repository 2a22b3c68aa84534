"""Rows in virtual time: the real engine without robots, so only its own work is measured."""

from __future__ import annotations

import itertools
import os
import statistics
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path

from fakes.line import Line
from fakes.long_journal import make_long_journal

from bench.line_files import cell_text, few_working_text, script_text
from bench.recipe_lines import drawn_line
from bench.rows import Row
from bench.whole_start import process_s
from bt_orchestrator.cli.bootstrap import installed_types
from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.engine.runtime.recovery import stamp
from bt_orchestrator.extensions.recipes.planning.generate import generate
from bt_orchestrator.model.events import TaskSucceeded
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.proof.deadlock import deadlock
from bt_orchestrator.model.proof.pace import PacedLine, pace
from bt_orchestrator.ros.types.status_messages import StatusWriter
from bt_orchestrator.script.cell_file import parse_cell, read_cell
from bt_orchestrator.script.script_file import parse_script, read_script
from bt_orchestrator.sim.gateway import VirtualClock, VirtualGateway
from bt_orchestrator.sim.pace_judge import PaceJudge
from bt_orchestrator.sim.simulation import Outcome, Simulation
from bt_orchestrator.store.memory import MemoryStore
from bt_orchestrator.store.sqlite.store import SqliteStore

ROOT = Path(__file__).parents[1]
QUEUED = (20, 800)

LENGTHS = (5, 20, 50, 100, 200)
"""Of lines in which five sections work."""


def seconds(work: Callable[[], object]) -> float:
    """Return the wall seconds of some work."""
    began = time.perf_counter()
    work()
    return time.perf_counter() - began


def cpu_s(work: Callable[[], object]) -> float:
    """Return the CPU seconds of some work."""
    began = time.process_time()
    work()
    return time.process_time() - began


def simulator(rounds: int, items: int) -> Iterator[Row]:
    """Run the reference cell in virtual time."""
    types = installed_types()
    cell = read_cell(ROOT / 'config' / 'reference_cell.yaml', types)
    script = read_script(ROOT / 'trees' / 'reference_process.yaml', cell, types)

    def speed() -> float:
        store = MemoryStore()
        simulation = Simulation(cell, types, store)
        simulation.submit([Job('WO-1', script, items, {'label': 'A7'})])
        wall_s = seconds(lambda: _finish(simulation))
        simulation.close()
        return sum(isinstance(event, TaskSucceeded) for event in store.read()) / wall_s

    yield Row('simulator', [speed() for _ in range(rounds)], {'items': items})


def sections(rounds: int, items: int) -> Iterator[Row]:
    """Compare a settle of a long and of a short line in which the same number works."""
    runs = [{length: _settle_s(length, items) for length in LENGTHS} for _ in range(rounds)]
    curve_ms = [min(run[length] for run in runs) * 1e3 for length in LENGTHS]
    notes = {'curves': {'sections': LENGTHS, 'ms a settle': curve_ms}}
    yield Row('sections', [run[LENGTHS[-1]] / run[LENGTHS[0]] for run in runs], notes)


def _settle_s(length: int, items: int) -> float:
    """Return the mean CPU seconds of a settle while the cell runs."""
    types = installed_types()
    cell = parse_cell(cell_text(length, 'a'), 'cell.yaml', types)
    script = parse_script(few_working_text(length), 'few.yaml', cell, types)
    simulation = Simulation(cell, types, MemoryStore())
    simulation.submit([Job('WO-1', script, items)])
    settles = 0

    def look() -> None:
        nonlocal settles
        settles += 1

    used_s = cpu_s(lambda: _finish(simulation, look))
    simulation.close()
    return used_s / settles


def queue(rounds: int, orders: int) -> Iterator[Row]:
    """Compare an order that joins a long queue with one that joins a short one."""
    few, many = QUEUED
    runs = [{waiting: _order_s(waiting, orders) for waiting in QUEUED} for _ in range(rounds)]
    notes = {f'ms an order, {n} queued': min(run[n] for run in runs) * 1e3 for n in QUEUED}
    yield Row('queue', [run[many] / run[few] for run in runs], notes)


def _order_s(waiting: int, orders: int) -> float:
    """Return the mean CPU seconds in which one order is queued, one is run, and a status told."""
    types = installed_types()
    cell = read_cell(ROOT / 'config' / 'reference_cell.yaml', types)
    script = read_script(ROOT / 'trees' / 'reference_process.yaml', cell, types)
    simulation = Simulation(cell, types, MemoryStore())
    engine = simulation.orchestrator
    writer, numbers = StatusWriter(), itertools.count()

    def give(number: int) -> None:
        jobs = [Job(f'WO-{next(numbers)}', script, 1, {'label': 'A7'}) for _ in range(number)]
        assert engine.ask(AddJobs(tuple(jobs))).accepted

    def give_one() -> None:
        give(1)
        before = len(engine.state.queue)
        while len(engine.state.queue) == before:
            assert simulation.clock.advance()
            engine.settle()
        writer.message(simulation.status())

    give(waiting)
    for _ in range(5):
        give_one()  # until the line is full
    began = time.process_time()
    for _ in range(orders):
        give_one()
    used_s = time.process_time() - began
    simulation.close()
    return used_s / orders


def check(rounds: int, length: int, tasks: int) -> Iterator[Row]:
    """Read and prove a long script."""
    types = installed_types()
    cell = parse_cell(cell_text(length), 'cell.yaml', types)
    text = script_text(length, tasks, flags=True)
    reading: list[float] = []

    def admit() -> None:
        began = time.perf_counter()
        script = parse_script(text, 'line.yaml', cell, types)
        reading.append(time.perf_counter() - began)
        assert deadlock(script) is None

    times = [seconds(admit) for _ in range(rounds)]
    yield Row('check', times, {'tasks': length * tasks, 'reading, s': min(reading)})


def pace_row(rounds: int, length: int) -> Iterator[Row]:
    """Compare the pace of a line with flags between its sections with a run that shows it."""
    types = installed_types()
    cell = parse_cell(cell_text(length), 'cell.yaml', types)
    script = parse_script(script_text(length, 3, flags=True), 'line.yaml', cell, types)
    line = PacedLine(script, cell)
    ratios, first_ms, again_ms = [], [], []
    for _ in range(rounds):
        first_s = cpu_s(lambda: pace(script, cell))
        again_ms.append(cpu_s(lambda: line.limit(line.durations(cell))) * 1e3)
        simulation = Simulation(cell, types, MemoryStore())
        simulation.submit([Job('WO-1', script, 60)])
        ratios.append(cpu_s(partial(_finish, simulation)) / first_s)
        simulation.close()
        first_ms.append(first_s * 1e3)
    notes = {'ms': min(first_ms), 'ms, with other durations': min(again_ms)}
    yield Row('pace', ratios, notes)


def recipes(lines: int, operations: int) -> Iterator[Row]:
    """Generate scripts for lines whose fastest script is known."""
    ratios, took_s, gaps = [], [], []
    for seed in range(lines):
        line = drawn_line(seed, operations, candidates=4)
        judge = PaceJudge(line.cell, installed_types(), MemoryStore)
        began = time.perf_counter()
        generated = generate(line.cell, line.recipe, judge=judge)
        took_s.append(time.perf_counter() - began)
        ratios.append(generated.claim.per_item_s / line.best_s)
        gaps.append(generated.claim.gap or 0.0)
    proven = sum(gap == 0 for gap in gaps)
    notes = {'operations': operations, 'lines': lines, 'proven': proven, 'gap': max(gaps)}
    yield Row('recipe_pace', ratios, notes)
    yield Row('recipe_time', took_s)


_STARTS = 5
"""In a round: one takes some milliseconds, and now and then a disk takes as many more."""


def restart(rounds: int, events: int) -> Iterator[Row]:
    """Start with a long journal, which is made once and kept, and with an empty one."""
    kept = _long_journal(events)
    with tempfile.TemporaryDirectory(prefix='bench_') as name:
        folder = Path(name)
        pairs = [
            (
                _median_start_s([kept] * _STARTS),
                _median_start_s([folder / f'{n}_{start}.sqlite3' for start in range(_STARTS)]),
            )
            for n in range(rounds)
        ]
        whole = [
            (process_s(kept, folder), process_s(folder / f'whole_{n}.sqlite3', folder))
            for n in range(rounds)
        ]
    ratios = [long / empty for long, empty in pairs]
    notes = {
        'events': events,
        'long, ms': pairs[-1][0] * 1e3,
        'empty, ms': pairs[-1][1] * 1e3,
        'whole process, long, s': statistics.median(long for long, _ in whole),
        'whole process, empty, s': statistics.median(empty for _, empty in whole),
    }
    yield Row('restart', ratios, notes)


def _long_journal(events: int) -> Path:
    """Return a journal that this very program has written: another one replays all of it."""
    prefix = f'bt_orchestrator_bench_{os.getuid()}_{events}'
    kept = Path(tempfile.gettempdir()) / f'{prefix}_{stamp(Line().cell)}.sqlite3'
    if not kept.exists():
        for other in kept.parent.glob(f'{prefix}[._]*'):
            other.unlink()
        part = kept.with_suffix('.part')
        make_long_journal(part, events)
        part.rename(kept)
    return kept


def _median_start_s(paths: Sequence[Path]) -> float:
    return statistics.median(_start_s(path) for path in paths)


def _start_s(path: Path) -> float:
    """Return the seconds from opening a journal to the end of the first settle."""
    line, clock = Line(), VirtualClock()
    began = time.perf_counter()
    store = SqliteStore(path)
    gateway = VirtualGateway(line.cell, line.types, clock)
    orchestrator = Orchestrator(line.cell, gateway, clock, store)
    orchestrator.settle()
    elapsed_s = time.perf_counter() - began
    orchestrator.close()
    store.close()
    return elapsed_s


def _finish(simulation: Simulation, look: Callable[[], None] = lambda: None) -> None:
    assert simulation.run(look) is Outcome.FINISHED
