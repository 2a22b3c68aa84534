"""Rows with real action servers: candidates take turns, and ratios are of one round."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterator

from bench.line_files import script_text
from bench.rows import Row, percentile
from bench.stand import TASKS_A_CYCLE, Measured, Stand, cpu_s, memory_mb, stand

OURS, NORMAL, WATCHED = 'ours FULL', 'ours NORMAL', 'ours watched'
CHAIN, POLLED, POLLED_FAST = 'rclpy chain', 'tree at 100 ms', 'tree at 10 ms'
OURS_EVENTS, CHAIN_EVENTS = 'ours FULL, events', 'rclpy chain, events'

Rounds = list[dict[str, Measured]]


def dispatch(rounds: int, cycles: int) -> Iterator[Row]:
    """Compare with a floor and with the convention."""
    with stand() as here:
        found = [_round(here, cycles) for _ in range(rounds)]
    p50 = _Ratios(found)
    latencies = {'latencies, s': _all(found, 'sequence'), 'wraps, s': _all(found, 'wrap')}
    yield Row('dispatch', p50.sequence(OURS, CHAIN), {**_figures(found), **latencies})
    yield Row(
        'polling',
        p50.sequence(POLLED, OURS),
        {
            '10 ms polling / ours': percentile(p50.sequence(POLLED_FAST, OURS), 0.5),
        },
    )
    yield Row(
        'wrap',
        p50.wrap(POLLED, OURS),
        {
            '10 ms polling / ours': percentile(p50.wrap(POLLED_FAST, OURS), 0.5),
        },
    )
    yield Row(
        'cpu',
        p50.cpu(OURS, CHAIN),
        {
            'events executor': percentile(p50.cpu(OURS_EVENTS, CHAIN_EVENTS), 0.5),
            **{f'{name}, ms CPU a task': found[-1][name].cpu_per_task * 1e3 for name in found[-1]},
        },
    )
    yield Row('watcher', p50.sequence(WATCHED, OURS))


def _round(here: Stand, cycles: int) -> dict[str, Measured]:
    return {
        CHAIN: here.by_hand('chain', 'single', cycles),
        OURS: here.ours(cycles, 'FULL', 'single'),
        NORMAL: here.ours(cycles, 'NORMAL', 'single'),
        WATCHED: here.ours(cycles, 'FULL', 'single', watched=True),
        POLLED: here.by_hand('polling_tree', '0.1', cycles),
        POLLED_FAST: here.by_hand('polling_tree', '0.01', cycles),
        CHAIN_EVENTS: here.by_hand('chain', 'events', cycles),
        OURS_EVENTS: here.ours(cycles, 'FULL', 'events'),
    }


class _Ratios:
    """Ratios of medians, one a round."""

    def __init__(self, rounds: Rounds) -> None:
        self._rounds = rounds

    def sequence(self, above: str, below: str) -> list[float]:
        """Of dispatch latencies within a section."""
        return [_p50(r[above].sequence) / _p50(r[below].sequence) for r in self._rounds]

    def wrap(self, above: str, below: str) -> list[float]:
        """Of those at the beginning of a cycle."""
        return [_p50(r[above].wrap) / _p50(r[below].wrap) for r in self._rounds]

    def cpu(self, above: str, below: str) -> list[float]:
        """Of CPU a task."""
        return [r[above].cpu_per_task / r[below].cpu_per_task for r in self._rounds]


def _p50(values: list[float]) -> float:
    return percentile(values, 0.5)


def _figures(rounds: Rounds) -> dict[str, float]:
    ratios = _Ratios(rounds)
    figures = {
        'NORMAL / chain': _p50(ratios.sequence(NORMAL, CHAIN)),
        'events executor, FULL / chain': _p50(ratios.sequence(OURS_EVENTS, CHAIN_EVENTS)),
    }
    for kind in ('sequence', 'wrap'):
        for name, values in _all(rounds, kind).items():
            figures[f'{name}, {kind} p50, ms'] = percentile(values, 0.5) * 1e3
            figures[f'{name}, {kind} p95, ms'] = percentile(values, 0.95) * 1e3
    return figures


def _all(rounds: Rounds, kind: str) -> dict[str, list[float]]:
    return {name: [v for r in rounds for v in getattr(r[name], kind)] for name in rounds[0]}


def setup(rounds: int) -> Iterator[Row]:
    """Start a node and give it an order of 300 or of 10 tasks, over the same ten actions."""
    with stand() as here:
        pairs = [(_set_up(here, 60), _set_up(here, 2)) for _ in range(rounds)]
    times = [many[0] / few[0] for many, few in pairs]
    notes = {'300 leaves, s': pairs[-1][0][0], '10 leaves, s': pairs[-1][1][0]}
    yield Row('setup_time', times, notes)
    memory = [many[1] / few[1] for many, few in pairs]
    yield Row('setup_memory', memory, {'300 leaves, MB': pairs[-1][0][1]})


def _set_up(here: Stand, tasks: int) -> tuple[float, float]:
    """Return seconds from the start of the process to the accepted order, and MB then."""
    script = here.folder / f'tasks_{tasks}.yaml'
    script.write_text(script_text(5, tasks, name=script.stem))
    began = time.monotonic()
    with here.node(['--no-auto-start']) as node:
        here.submit('WO-1', 1, script)
        return time.monotonic() - began, memory_mb(node.pid)


def idle(rounds: int, seconds: float) -> Iterator[Row]:
    """Compare nodes that have nothing to do."""
    with stand() as here:
        pairs = [(_idle_ours(here, seconds), _idle_empty(seconds)) for _ in range(rounds)]
    notes = {
        'ours, % of a core': pairs[-1][0] * 100,
        'empty node, % of a core': pairs[-1][1] * 100,
    }
    yield Row('idle', [ours / max(empty, 1e-4) for ours, empty in pairs], notes)


def _idle_ours(here: Stand, seconds: float) -> float:
    with here.node([]) as node:
        return _load(node.pid, seconds)


def _idle_empty(seconds: float) -> float:
    command = [sys.executable, '-m', 'bench.empty_node']
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        process.stdout.readline()
        used = _load(process.pid, seconds)
        process.kill()
        return used


def _load(pid: int, seconds: float) -> float:
    """Return the share of a core that a process uses, its first second left out."""
    time.sleep(1.0)
    before, began = cpu_s(pid), time.monotonic()
    time.sleep(seconds)
    return (cpu_s(pid) - before) / (time.monotonic() - began)


def drift(tasks: int) -> Iterator[Row]:
    """Run many tasks, and compare the last tenth with the first, after a warm-up."""
    part = max(tasks // 10 // TASKS_A_CYCLE, 1)
    with stand() as here, here.node(['--journal', str(here.folder / 'long.sqlite3')]) as node:
        points = []
        _run(here, 'WARM', min(25, part))
        for n in range(10):
            before_s = cpu_s(node.pid)
            _run(here, f'WO-{n}', part)
            used_s = cpu_s(node.pid) - before_s
            points.append((used_s / part / TASKS_A_CYCLE, memory_mb(node.pid)))
    (first_cpu, first_mb), (last_cpu, last_mb) = points[0], points[-1]
    curves = {'ms a task': [c * 1e3 for c, _ in points], 'MB': [mb for _, mb in points]}
    yield Row('drift_cpu', [last_cpu / first_cpu], {'tasks': tasks, **curves})
    yield Row('drift_memory', [last_mb / first_mb], {'first, MB': first_mb, 'last, MB': last_mb})


def _run(here: Stand, order: str, items: int) -> None:
    offset = here.log.stat().st_size
    here.submit(order, items)
    here.until_ended(offset, items * TASKS_A_CYCLE, patience_s=60.0 + items)
