"""Run a line far larger than most to its end, and say what that cost."""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from itertools import chain
from pathlib import Path
from typing import Any

import interrupts
from bt_orchestrator_interfaces.srv import SubmitOrder
from fakes.journal_reading import journal_reading
from process_use import cpu_s, memory_mb
from program_process import ProgramProcess
from ros_domain import OwnDomain

from bench.line_files import cell_text, script_text
from bench.rows import percentile
from bench.tail import until
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.ros.link.client import NodeClient

ORDER = 'WO-1'

PATIENCE_S = 300.0
"""For everybody to find everybody."""

RESULT_TIMEOUT_S = 10.0
"""As servers have it by default: a hundred sections begin at once, and the last answer is late."""

_BAD = ('task.failed', 'hold.raised', 'job.aborted')

STUCK_S = 120.0
"""A line of which nothing was heard for that long stands still."""


class LargeLine:
    """Controllers in several processes and the tree node that drives them. A context."""

    def __init__(self, folder: Path, args: argparse.Namespace) -> None:
        letters = 'abcdefghijklmnop'[: args.components // args.sections]
        self._cell = folder / 'cell.yaml'
        text = cell_text(args.sections, letters, result_timeout_s=RESULT_TIMEOUT_S)
        self._cell.write_text(text)
        self._script = folder / 'line.yaml'
        self._script.write_text(script_text(args.sections, len(letters), letters=letters))
        self.goals = args.items * args.sections * len(letters) + args.items + args.sections - 1
        """Those of the items, and the moves of the belt."""
        self._names = ['conveyor']
        self._names += [f'{letter}{n}' for n in range(1, args.sections + 1) for letter in letters]
        self._folder = folder
        self._journal = folder / 'journal.sqlite3'
        self._args = args
        self._open = ExitStack()

    def __enter__(self) -> LargeLine:
        return self

    def __exit__(self, *exception: object) -> None:
        self._open.close()

    def start(self) -> Iterator[str]:
        """Start everybody; yield how long that took."""
        begun = time.monotonic()
        cell = ['--cell', str(self._cell)]
        self._controllers = [
            self._run(
                f'controllers_{number}',
                [
                    'sim-cell',
                    *cell,
                    '--result-timeout',
                    f'{RESULT_TIMEOUT_S}',
                    *self._share(number),
                ],
            )
            for number in range(self._args.processes)
        ]
        for process in self._controllers:
            _wait_ready(process)
        yield f'controllers ready after {time.monotonic() - begun:.1f} s'
        begun = time.monotonic()
        options = ['--executor', self._args.executor, '--journal', str(self._journal)]
        options += ['--trees', str(self._cell.parent)]
        self._node = self._run('node', ['run', *cell, *options])
        _wait_ready(self._node)
        yield f'tree node ready after {time.monotonic() - begun:.1f} s'
        with NodeClient('/bt_orchestrator', PATIENCE_S) as client:
            states: list[Any] = []
            client.on_status(states.append)
            client.wait_until(lambda: bool(states) and _all_there(states[-1]), 'every server')
        yield f'every server found after {time.monotonic() - begun:.1f} s'

    def run(self) -> Iterator[str]:
        """Run the job; yield what it cost."""
        request = SubmitOrder.Request(
            order=ORDER, script=str(self._script), quantity=self._args.items
        )
        used_s = cpu_s(self._node.pid)
        theirs_s = sum(cpu_s(process.pid) for process in self._controllers)
        begun = time.monotonic()
        with NodeClient('/bt_orchestrator', PATIENCE_S) as client:
            answer = client.call(SubmitOrder, 'submit_order', request)
        if not answer.accepted:
            raise SystemExit(f'the order was refused: {answer.message} {answer.findings}')
        yield f'order accepted after {time.monotonic() - begun:.1f} s'
        self._until_ended()
        took_s = time.monotonic() - begun
        used_s = cpu_s(self._node.pid) - used_s
        theirs_s = sum(cpu_s(process.pid) for process in self._controllers) - theirs_s
        yield f'{self.goals} goals in {took_s:.0f} s: {self.goals / took_s:.0f} a second'
        busy = f'{used_s / took_s:.0%} busy'
        yield f'tree node: {used_s / self.goals * 1e3:.2f} ms CPU a goal, {busy}'
        yield f'controllers: {theirs_s / self.goals * 1e3:.2f} ms CPU a goal'
        yield f'memory of the tree node: {memory_mb(self._node.pid):.0f} MB'
        yield f'journal: {self._last_seq()} events, {self._journal.stat().st_size / 1e6:.0f} MB'
        gaps = sorted(_gaps(self._folder / 'goals.jsonl'))
        yield (
            'end of a task to the arrival of the next goal of its section: '
            f'p50 {percentile(gaps, 0.5) * 1e3:.1f} ms, p95 {percentile(gaps, 0.95) * 1e3:.1f} ms'
        )

    def _share(self, number: int) -> list[str]:
        names = ','.join(self._names[number :: self._args.processes])
        speed = ['--speed', str(self._args.speed)]
        return ['--only', names, *speed, '--log', str(self._folder / 'goals.jsonl')]

    def _run(self, name: str, words: Sequence[str]) -> ProgramProcess:
        process = ProgramProcess(words, self._folder, name)
        self._open.callback(process.stop)
        return process

    def _until_ended(self) -> None:
        seen, heard = 0, time.monotonic()

        def is_over() -> bool:
            nonlocal seen, heard
            with journal_reading(self._journal) as journal:
                last = journal.records.extent().last_seq
                wanted = Wanted(after_seq=seen, events=(*_BAD, 'job.completed'))
                records = [json.loads(record) for _, record in journal.each(wanted)]
            if last > seen:
                seen, heard = last, time.monotonic()
            elif time.monotonic() - heard > STUCK_S:
                raise SystemExit(f'nothing happened for {STUCK_S:g} s')
            if bad := [record for record in records if record['event'] in _BAD]:
                raise SystemExit(f'the job did not go well: {bad}')
            return bool(records)

        until(is_over, 'the end of the job', float('inf'))

    def _last_seq(self) -> int:
        with journal_reading(self._journal) as journal:
            return journal.records.extent().last_seq


def _wait_ready(process: ProgramProcess) -> None:
    until(lambda: not process.is_running or 'ready: ' in process.output, 'ready', PATIENCE_S)
    process.wait_ready()


def _all_there(status: Any) -> bool:
    return all(component.available for component in status.components)


def _gaps(log: Path) -> Iterator[float]:
    """Yield the time from each end to the next goal of the same section, s."""
    ended: dict[str, float] = {}
    with log.open() as lines:
        for record in map(json.loads, lines):
            letter, section = record['component'][0], record['component'][1:]
            if record['event'] == 'ended':
                ended[section] = record['time']
            elif record['event'] == 'accepted' and letter != 'a' and section in ended:
                yield record['time'] - ended.pop(section)


def main() -> int:
    """Run one large line and print what it cost."""
    parser = argparse.ArgumentParser(prog='scripts/bench-scale', description=__doc__)
    parser.add_argument('--sections', type=int, default=100)
    parser.add_argument('--components', type=int, default=300, help='in all, without the belt')
    parser.add_argument('--items', type=int, default=200)
    parser.add_argument('--processes', type=int, default=6, help='of simulated controllers')
    parser.add_argument('--speed', type=float, default=1.0, help='of the controllers')
    parser.add_argument('--executor', choices=('single', 'events'), default='events')
    args = parser.parse_args()
    interrupts.heed()
    print(f'{os.cpu_count()} cores, load {os.getloadavg()[0]:.2f}; {vars(args)}', flush=True)
    scratch = tempfile.TemporaryDirectory(prefix='scale_', dir='/var/tmp')
    with OwnDomain(), scratch as folder, LargeLine(Path(folder), args) as line:
        for message in chain(line.start(), line.run()):
            print(message, flush=True)
    return 0


if __name__ == '__main__':
    sys.exit(main())
