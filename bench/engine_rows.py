"""Rows of the engine alone, in turns with the engine of another revision.

Each package runs in a process of its own, which stays: every turn is warm. Both processes get the
same cell file and script, those of the other revision. Only one works at a time.
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from bench.rows import Row, percentile

ROOT = Path(__file__).parents[1]
JOURNALS = {'engine': 'memory', 'engine_normal': 'NORMAL'}
PARTS = ('bt_orchestrator', 'config', 'trees')
HERE = 'these files'


def engine(rounds: int, items: int, against: str | None = None) -> Iterator[Row]:
    """Measure the engine of these files.

    :param against: a revision, which takes turns with it; its engine is the divisor of the ratios
    """
    with ExitStack() as stack:
        other = None if against is None else stack.enter_context(_unpacked(against))
        trees = {HERE: ROOT} | ({} if other is None or against is None else {against: other})
        runs = {
            name: stack.enter_context(_process(tree, other or ROOT))
            for name, tree in trees.items()
        }
        for key, journal in JOURNALS.items():
            yield from _rows(key, journal, rounds, items, runs)


def _rows(
    key: str, journal: str, rounds: int, items: int, runs: dict[str, subprocess.Popen[str]]
) -> Iterator[Row]:
    names = list(runs)
    counted = {name: _run(runs[name], f'{journal} {items} count') for name in names}
    for name in names:
        _run(runs[name], f'{journal} {items}')  # warms up
    us: dict[str, list[float]] = {name: [] for name in names}
    for number in range(rounds):
        for name in names if number % 2 else reversed(names):
            us[name].append(_run(runs[name], f'{journal} {items}')['settle_us'])
    notes = {f'{name}, bytecodes a task': counted[name]['bytecodes'] for name in names}
    notes |= {f'{name}, least, us a task': min(us[name]) for name in names}
    yield Row(key, us[HERE], notes)
    for name in names[1:]:
        ratios = [ours / other for ours, other in zip(us[HERE], us[name], strict=True)]
        quarters = {f'quarter at {n} %': percentile(ratios, n / 100) for n in (25, 75)}
        least = {'of the least': min(us[HERE]) / min(us[name])}
        codes = counted[HERE]['bytecodes'] / counted[name]['bytecodes']
        middle = {f'{name}, p50, us a task': statistics.median(us[name]), 'of bytecodes': codes}
        yield Row(f'{key}_against', ratios, {**quarters, **least, **middle})


@contextmanager
def _unpacked(revision: str) -> Iterator[Path]:
    """Unpack the package and the shipped files of a revision."""
    command = ['git', '-C', str(ROOT), 'archive', revision, *PARTS]
    archive = subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout
    with tempfile.TemporaryDirectory(prefix='bench_') as folder:
        subprocess.run(['tar', '--extract', '-C', folder], input=archive, check=True)
        yield Path(folder)


@contextmanager
def _process(tree: Path, files: Path) -> Iterator[subprocess.Popen[str]]:
    """Run the engine of a tree, which waits for orders."""
    program = Path(__file__).with_name('engine.py')
    command = [sys.executable, str(program), '--serve', '--files', str(files)]
    environment = {**os.environ, 'PYTHONPATH': str(tree), 'PYTHONHASHSEED': '0'}
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment
    ) as process:
        try:
            yield process
        finally:
            process.kill()


def _run(process: subprocess.Popen[str], order: str) -> dict[str, Any]:
    assert process.stdin is not None
    assert process.stdout is not None
    print(order, file=process.stdin, flush=True)
    result: dict[str, Any] = json.loads(process.stdout.readline())
    return result
