"""The programs of a demo: simulated controllers in two processes, the tree node in a third."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace

from bt_orchestrator.cli.demo_folder import DemoFolder, DemoRecord, is_ours, stop_process
from bt_orchestrator.cli.programs import Program, ProgramFailed
from bt_orchestrator.model.cell import Cell

READY_S = 60.0
"""Longest time that a program may take to be ready, on a slow and busy machine."""

NODE = 'tree node'


class DemoPrograms:
    """States: to be started, running, finished.

    A program that an earlier demo has left running is taken over as it is: the controllers, above
    all, which know what became of their goals.
    """

    def __init__(self, folder: DemoFolder, record: DemoRecord) -> None:
        self._folder = folder
        self._record = record
        self._taken_over = {n: pid for n, pid in record.processes.items() if is_ours(pid)}
        self._started: dict[str, Program] = {}
        self._goes_on = False

    def start(self, args: argparse.Namespace, cell: Cell) -> None:
        """Start what does not run yet, and wait until all of it is ready.

        :raises ProgramFailed: one of them ends instead
        """
        for name, verb in self._verbs(args, cell):
            if name in self._taken_over:
                print(f'[{self._taken_over[name]}] {name} still runs', flush=True)
                continue
            log = self._folder.path / f'{name.replace(" ", "_")}.log'
            self._started[name] = Program(verb, log, {})
            self._keep()
        for program in self._started.values():
            print(f'[{program.pid}] {program.wait_ready("ready", READY_S)}', flush=True)

    def check(self) -> None:
        """Look after the tree node.

        :raises ProgramFailed: it has gone; the controllers stay, for a demo that is resumed
        """
        node = self._started.get(NODE)
        gone = node.ended if node else not is_ours(self._taken_over[NODE])
        if gone:
            self._goes_on = True
            raise ProgramFailed(
                'the tree node has gone, and the controllers go on with what they do; take over '
                'with: bt-orchestrator demo --resume (a new demo without it ends them)'
            )

    def finish(self) -> None:
        """End everything, the node first, unless somebody is to go on with it."""
        if self._goes_on:
            return
        for program in reversed(list(self._started.values())):
            program.stop()
        for pid in reversed(list(self._taken_over.values())):
            stop_process(pid)
        self._folder.forget()

    def _keep(self) -> None:
        pids = {name: program.pid for name, program in self._started.items()}
        self._folder.keep(replace(self._record, processes={**self._taken_over, **pids}))

    def _verbs(self, args: argparse.Namespace, cell: Cell) -> Iterator[tuple[str, list[str]]]:
        names = list(cell.components)
        halves = (names[: len(names) // 2], names[len(names) // 2 :])
        for number, half in enumerate(halves, 1):
            verb = ['sim-cell', '--cell', self._record.cell, '--speed', str(args.speed)]
            verb += ['--only', ','.join(half)]
            for fault in args.fail:
                if fault.split('.')[0].split('#')[0] in half:
                    verb += ['--fail', fault]
            yield f'controllers {number}', verb
        verb = ['run', '--cell', self._record.cell, '--executor', args.executor]
        verb += ['--journal', str(self._folder.journal), '--auto-resume', '--script-paths']
        for trees in args.trees:
            verb += ['--trees', str(trees)]
        yield NODE, verb
