"""Row of the readers of a journal: what the node pays while others read what it writes.

One node drives the line all the time. It is measured in turns: alone; while the verbs that read go
through its journal again and again, and `report --follow` goes on with it; beside a process that
only computes.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import NamedTuple

from fakes.line import TYPES, Line
from fakes.long_journal import make_long_journal
from process_use import cpu_s

from bench.line_files import SECTIONS, cell_text, script_text
from bench.rows import Row, percentile
from bench.stand import ENDLESS, TASKS_A_CYCLE, Stand, sequences, stand
from bench.tail import Tail, until
from bt_orchestrator.model.script import Script
from bt_orchestrator.script.cell_file import parse_cell
from bt_orchestrator.script.script_file import parse_script

ALONE, READ, BESIDE = 'alone', 'read', 'beside a process that computes'
WARM_UP = 20
"""Cycles before the first measurement."""


class _Used(NamedTuple):
    """What the node did in a while."""

    latencies_s: list[float]
    cpu_s: float
    """A task."""


def readers(rounds: int, cycles: int, events: int) -> Iterator[Row]:
    """Measure the node in turns.

    :param cycles: how long each turn is
    :param events: that are in the journal at the beginning
    """
    uses: list[dict[str, _Used]] = []
    with stand() as here:
        journal = _journal(here)
        make_long_journal(journal, events, line=_OfStand(), text=script_text(SECTIONS))
        with here.node(['--journal', str(journal)]) as node:
            tail = here.tail()
            here.submit('READ', ENDLESS)
            tail.until_ended(WARM_UP * TASKS_A_CYCLE)
            for number in range(rounds):
                turns = (ALONE, READ, BESIDE) if number % 2 else (BESIDE, READ, ALONE)
                uses.append({turn: _turn(turn, here, tail, node.pid, cycles) for turn in turns})
    yield Row('readers', _ratios(uses, READ, ALONE), _figures(uses, events))
    cpu = [use[READ].cpu_s / use[ALONE].cpu_s for use in uses]
    yield Row('readers_cpu', cpu)


def _turn(turn: str, here: Stand, tail: Tail, pid: int, cycles: int) -> _Used:
    with ExitStack() as stack:
        for words in _processes(turn, here):
            stack.enter_context(_running(words, here))
        tail.until_ended(0)  # reads what was done until they began
        first, tasks, before_s = len(tail.records), tail.ended, cpu_s(pid)
        tail.until_ended(tasks + cycles * TASKS_A_CYCLE)
        used_s, done = cpu_s(pid) - before_s, tail.ended - tasks
    return _Used(list(sequences(tail.records[first:])), used_s / done)


def _processes(turn: str, here: Stand) -> Iterator[list[str]]:
    """Yield what Python runs in a turn."""
    if turn == BESIDE:
        yield ['bench.reader', '-']
    elif turn == READ:
        journal, cell = str(_journal(here)), str(here.cell)
        yield ['bench.reader', journal, cell]
        of = ['--journal', journal, '--cell', cell]
        yield ['bt_orchestrator', 'report', *of, '--follow', '--json', '--every', '0.5']


@contextmanager
def _running(words: list[str], here: Stand) -> Iterator[None]:
    """Run a process; it has begun when it has said something."""
    log = here.folder / here.name('reader')
    with log.open('w') as output:
        process = subprocess.Popen([sys.executable, '-m', *words], stdout=output, stderr=output)
    try:
        until(lambda: log.stat().st_size > 0, f'the first words of {words}')
        yield
        assert process.poll() is None, log.read_text()
    finally:
        process.kill()
        process.wait()


def _journal(here: Stand) -> Path:
    return here.folder / 'read.sqlite3'


class _OfStand(Line):
    """The cell of the stand, for a run in virtual time."""

    def __init__(self) -> None:
        self.text = cell_text(SECTIONS)
        self.types = TYPES
        self.cell = parse_cell(self.text, 'cell.yaml', TYPES)

    def script(self, text: str, name: str = 'line') -> Script:
        return parse_script(text, f'{name}.yaml', self.cell, TYPES)


def _ratios(rounds: list[dict[str, _Used]], above: str, below: str) -> list[float]:
    return [_p50(use[above]) / _p50(use[below]) for use in rounds]


def _p50(used: _Used) -> float:
    return percentile(used.latencies_s, 0.5)


def _figures(rounds: list[dict[str, _Used]], events: int) -> dict[str, float]:
    figures: dict[str, float] = {'events in the journal at the beginning': events}
    for turn in (ALONE, READ, BESIDE):
        values = [latency for used in rounds for latency in used[turn].latencies_s]
        figures[f'{turn}, p50, ms'] = percentile(values, 0.5) * 1e3
        figures[f'{turn}, p95, ms'] = percentile(values, 0.95) * 1e3
        cpu = percentile([used[turn].cpu_s for used in rounds], 0.5)
        figures[f'{turn}, ms CPU a task'] = cpu * 1e3
    figures[f'{BESIDE} / alone'] = percentile(_ratios(rounds, BESIDE, ALONE), 0.5)
    figures[f'read / {BESIDE}'] = percentile(_ratios(rounds, READ, BESIDE), 0.5)
    return figures
