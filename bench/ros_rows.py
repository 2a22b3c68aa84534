"""Rows with real action servers: candidates take turns, and ratios are of one round."""

from __future__ import annotations

import itertools
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from process_use import cpu_s, memory_mb

from bench.chain import PLAIN
from bench.counted_node import FILE
from bench.recipe_files import OPERATIONS, able_cell_text, write_recipe
from bench.rows import Row, percentile
from bench.staged import ENDS
from bench.stamped import FILE as STAMPS
from bench.stand import (
    TASKS_A_CYCLE,
    WARM_UP,
    Measured,
    Ratios,
    Stand,
    in_turns,
    p50,
    stand,
    watcher,
)
from bench.tail import until
from bt_orchestrator.ros.node_parameters import EVENTS, SINGLE

OURS, NORMAL, WATCHED = 'ours FULL', 'ours NORMAL', 'ours watched'
CHAIN, CHAIN_LEAN = 'rclpy chain', 'rclpy chain, our executor'
POLLED, POLLED_FAST = 'tree at 100 ms', 'tree at 10 ms'
OURS_EVENTS, CHAIN_EVENTS = 'ours FULL, events', 'rclpy chain, events'

REST_S = 0.02
"""Before each write that is measured cold."""

SETTLED_S = 1.0
"""After its start a process discovers others for a while."""

Rounds = list[dict[str, Measured]]


def dispatch(rounds: int, cycles: int) -> Iterator[Row]:
    """Compare with a floor and with the convention."""
    with stand() as here:
        results, writes = [], []
        for number in range(rounds):
            results.append(_round(here, cycles, number))
            writes.append(_cold_write_s(here.folder))
    ratios = Ratios(results)
    disk = {
        'FULL with the disk / chain': p50(ratios.sequence(OURS, CHAIN_LEAN)),
        'cold durable write of 4 kB, median, ms': p50(writes) * 1e3,
        'cold durable write of 4 kB, longest round, ms': max(writes) * 1e3,
    }
    latencies = {'latencies, s': _all(results, 'sequence'), 'wraps, s': _all(results, 'wrap')}
    figures = {**_figures(results), **disk, **latencies}
    rounds_less_disk = [
        (r[OURS], write, r[CHAIN_LEAN]) for r, write in zip(results, writes, strict=True)
    ]
    yield Row(
        'dispatch',
        [
            (p50(ours.sequence) - write) / p50(chain.sequence)
            for ours, write, chain in rounds_less_disk
        ],
        figures,
    )
    yield Row('dispatch_normal', ratios.sequence(NORMAL, CHAIN_LEAN))
    yield Row(
        'wrap',
        [(p50(ours.wrap) - write) / p50(chain.wrap) for ours, write, chain in rounds_less_disk],
        {'FULL with the disk / chain': p50(ratios.wrap(OURS, CHAIN_LEAN))},
    )
    yield Row('polling', ratios.sequence(POLLED, OURS), {'wrap': p50(ratios.wrap(POLLED, OURS))})
    wrap_fast = {'wrap': p50(ratios.wrap(POLLED_FAST, OURS))}
    yield Row('polling_fast', ratios.sequence(POLLED_FAST, OURS), wrap_fast)
    cpu_ms = {
        f'{n}, ms CPU a task': p50([r[n].cpu_per_task for r in results]) * 1e3 for n in results[0]
    }
    others = {
        'without waiting for the disk (NORMAL)': p50(ratios.cpu(NORMAL, CHAIN_LEAN)),
        "ours / chain on rclpy's executor": p50(ratios.cpu(OURS, CHAIN)),
        'events executor, ours / chain': p50(ratios.cpu(OURS_EVENTS, CHAIN_EVENTS)),
    }
    yield Row('cpu', ratios.cpu(OURS, CHAIN_LEAN), {**others, **cpu_ms})
    yield Row('watcher', ratios.sequence(WATCHED, OURS))


def own_part(rounds: int, cycles: int) -> Iterator[Row]:
    """Compare what we do from the end of a wait to the first goal with what the chain does.

    A cold durable write of the same round is taken off: the chain keeps nothing.
    """
    ours: list[float] = []
    chain: list[float] = []
    writes: list[float] = []
    with stand() as here:
        for number in range(rounds):
            for is_ours in (True, False) if number % 2 else (False, True):
                target = ours if is_ours else chain
                target.append(p50(_stamped(here, cycles, is_ours=is_ours)))
            writes.append(_cold_write_s(here.folder))
        stages = _stages(here, cycles * min(rounds, 4))
    ratios = [(own - write) / plain for own, write, plain in zip(ours, writes, chain, strict=True)]
    notes = {
        'ours, p50, ms': p50(ours) * 1e3,
        'chain, p50, ms': p50(chain) * 1e3,
        'cold durable write, p50, ms': p50(writes) * 1e3,
        **stages,
    }
    yield Row('own_part', ratios, notes)


def _stages(here: Stand, cycles: int) -> dict[str, float]:
    """Return the medians of what our own part consists of, in ms."""
    file = here.folder / here.name('stages')
    os.environ[STAMPS] = str(file)
    here.ours(cycles, 'FULL', SINGLE, program='bench.staged')
    kinds = zip(('one goal', 'several goals'), json.loads(file.read_text()), strict=True)
    return {
        f'{kind}: {stage}, ms': p50([turn[stage] for turn in turns[WARM_UP:]]) * 1e3
        for kind, turns in kinds
        for stage in ENDS
    }


def _stamped(here: Stand, cycles: int, *, is_ours: bool) -> list[float]:
    """Return the times of the turns behind the warm-up."""
    file = here.folder / here.name('stamps')
    os.environ[STAMPS] = str(file)
    if is_ours:
        here.ours(cycles, 'FULL', SINGLE, program='bench.stamped')
    else:
        here.by_hand('stamped', SINGLE, cycles)
    taken_s: list[float] = json.loads(file.read_text())
    return taken_s[len(taken_s) * WARM_UP // (WARM_UP + cycles) :]


def _cold_write_s(folder: Path) -> float:
    """Return the time of the smallest commit with FULL after a rest, as between two tasks.

    In a loop without rest the same write takes half of that, from warm caches.
    """
    times = []
    with (folder / 'sync').open('wb', buffering=0) as file:
        for _ in range(30):
            time.sleep(REST_S)
            began = time.perf_counter()
            file.write(bytes(4096))
            os.fdatasync(file.fileno())
            times.append(time.perf_counter() - began)
    return p50(times)


def _round(here: Stand, cycles: int, number: int) -> dict[str, Measured]:
    """Let every candidate drive once."""
    drives: dict[str, Callable[[], Measured]] = {
        CHAIN: lambda: here.by_hand('chain', PLAIN, cycles),
        OURS: lambda: here.ours(cycles, 'FULL', SINGLE),
        CHAIN_LEAN: lambda: here.by_hand('chain', SINGLE, cycles),
        WATCHED: lambda: here.ours(cycles, 'FULL', SINGLE, attached=watcher),
        NORMAL: lambda: here.ours(cycles, 'NORMAL', SINGLE),
        POLLED: lambda: here.by_hand('polling_tree', '0.1', cycles),
        POLLED_FAST: lambda: here.by_hand('polling_tree', '0.01', cycles),
        CHAIN_EVENTS: lambda: here.by_hand('chain', EVENTS, cycles),
        OURS_EVENTS: lambda: here.ours(cycles, 'FULL', EVENTS),
    }
    return in_turns(drives, number)


def _p95(values: list[float]) -> float:
    return percentile(values, 0.95)


def _figures(rounds: Rounds) -> dict[str, float]:
    ratios = Ratios(rounds)
    figures = {
        "FULL / chain on rclpy's executor": p50(ratios.sequence(OURS, CHAIN)),
        "wrap, FULL / chain on rclpy's executor": p50(ratios.wrap(OURS, CHAIN)),
        'events executor, FULL / chain': p50(ratios.sequence(OURS_EVENTS, CHAIN_EVENTS)),
    }
    for kind in ('sequence', 'wrap'):
        for name, values in _all(rounds, kind).items():
            figures[f'{name}, {kind} p50, ms'] = p50(values) * 1e3
            figures[f'{name}, {kind} p95, ms'] = _p95(values) * 1e3
    return figures


def _all(rounds: Rounds, kind: str) -> dict[str, list[float]]:
    return {name: [v for r in rounds for v in getattr(r[name], kind)] for name in rounds[0]}


def planning(rounds: int, cycles: int) -> Iterator[Row]:
    """Drive the line while the node generates scripts of recipes, and without, in turns.

    It generates as long as is measured, each recipe once: nothing of it is known before.
    """
    pairs: list[tuple[Measured, Measured]] = []
    with stand(able_cell_text()) as here:
        recipes = (write_recipe(here.folder, number) for number in itertools.count())
        for number in range(rounds):
            turns = (None, recipes) if number % 2 else (recipes, None)
            first, second = (here.ours(cycles, 'FULL', SINGLE, recipes=turn) for turn in turns)
            pairs.append((first, second) if turns[0] is None else (second, first))
    ratios = [p50(beside.sequence) / p50(alone.sequence) for alone, beside in pairs]
    notes = {
        'made in a round': min(beside.made for _, beside in pairs),
        'operations of each': OPERATIONS,
        'p95': p50([_p95(beside.sequence) / _p95(alone.sequence) for alone, beside in pairs]),
        'alone, p50, ms': p50([p50(alone.sequence) for alone, _ in pairs]) * 1e3,
    }
    yield Row('recipe_load', ratios, notes)


def setup(rounds: int) -> Iterator[Row]:
    """Set up a line of 300 and of 10 tasks over the same ten actions, each in a new process."""
    with stand():
        pairs = [(_set_up(60), _set_up(2)) for _ in range(rounds)]
    for key, unit in (('setup_time', 's'), ('setup_memory', 'mb')):
        notes = {
            f'300 leaves, {unit}': p50([many[unit] for many, _ in pairs]),
            f'10 leaves, {unit}': p50([few[unit] for _, few in pairs]),
        }
        yield Row(key, [many[unit] / few[unit] for many, few in pairs], notes)


def _set_up(tasks: int) -> dict[str, float]:
    command = [sys.executable, '-m', 'bench.setup_cost', str(tasks)]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
    costs: dict[str, float] = json.loads(done.stdout)
    return costs


def idle(rounds: int, seconds: float) -> Iterator[Row]:
    """Compare nodes that have nothing to do."""
    with stand() as here:
        pairs = [(_idle_ours(here, seconds), _idle_empty(seconds)) for _ in range(rounds)]
    notes = {
        'ours, % of a core': p50([ours for ours, _ in pairs]) * 100,
        'empty node, % of a core': p50([empty for _, empty in pairs]) * 100,
    }
    yield Row('idle', [ours / empty for ours, empty in pairs], notes)


def _idle_ours(here: Stand, seconds: float) -> float:
    with here.node([]) as node:
        return _load(node.pid, seconds)


def _idle_empty(seconds: float) -> float:
    command = [sys.executable, '-m', 'bench.empty_node']
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            process.stdout.readline()
            return _load(process.pid, seconds)
        finally:
            process.kill()


def _load(pid: int, seconds: float) -> float:
    """Return the share of a core that a process uses once it has settled."""
    time.sleep(SETTLED_S)
    before, began = cpu_s(pid), time.monotonic()
    time.sleep(seconds)
    return (cpu_s(pid) - before) / (time.monotonic() - began)


def drift(tasks: int) -> Iterator[Row]:
    """Run many tasks, and compare the last tenth with the first, after a warm-up."""
    part = max(tasks // 10 // TASKS_A_CYCLE, 1)
    points: list[tuple[float, float, int]] = []
    with stand() as here:
        file = here.folder / 'futures'
        os.environ[FILE] = str(file)
        options = ['--journal', str(here.folder / 'long.sqlite3')]
        with here.node(options, 'bench.counted_node') as node:
            _run(here, 'WARM', min(25, part))
            for n in range(10):
                before_s = cpu_s(node.pid)
                _run(here, f'WO-{n}', part)
                used_s = cpu_s(node.pid) - before_s
                a_task_s = used_s / part / TASKS_A_CYCLE
                points.append((a_task_s, memory_mb(node.pid), _futures(node.pid, file)))
    (first_cpu, first_mb, _), (last_cpu, last_mb, _) = points[0], points[-1]
    curves = {
        'tasks': [(n + 1) * part * TASKS_A_CYCLE for n in range(10)],
        'ms CPU a task': [cpu * 1e3 for cpu, _, _ in points],
        'MB': [mb for _, mb, _ in points],
        'futures of rclpy': [count for _, _, count in points],
    }
    notes = {'futures of rclpy, first': points[0][2], 'futures of rclpy, last': points[-1][2]}
    yield Row('drift_cpu', [last_cpu / first_cpu], {'tasks': tasks, 'curves': curves, **notes})
    yield Row('drift_memory', [last_mb / first_mb], {'first, MB': first_mb, 'last, MB': last_mb})


def _futures(pid: int, file: Path) -> int:
    """Return how many of rclpy's futures a node holds, of requests without an answer or not."""
    file.unlink(missing_ok=True)
    os.kill(pid, signal.SIGUSR1)
    until(file.exists, 'the number of futures')
    return int(file.read_text())


def _run(here: Stand, order: str, items: int) -> None:
    tail = here.tail()
    here.submit(order, items)
    tail.until_ended(items * TASKS_A_CYCLE, patience_s=60.0 + items)
