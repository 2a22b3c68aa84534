"""The programs of a demo: simulated controllers in two processes, tree node, page, OPC UA."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from bt_orchestrator.cli.demo.folder import DemoFolder, DemoRecord, is_ours, stop_process
from bt_orchestrator.cli.programs import Program, ProgramFailed
from bt_orchestrator.model.by import Role
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.script.users.file import UsersFile

# The one user of a demo's OPC UA server: it needs a login, and everybody may know this one.

NAME, PASSWORD = 'demo', 'only-for-demos'


def opcua_options(folder: Path) -> list[str]:
    """Write the user; returns the options with which the server lets clients in.

    :param folder: of the demo; the server's certificate is kept there as well
    """
    users = folder / 'users.yaml'
    users.unlink(missing_ok=True)
    UsersFile(users).add(NAME, Role.ENGINEER, PASSWORD)
    return ['--insecure', '--users', str(users), '--pki', str(folder / 'pki')]


# The programs of a demo: simulated controllers in two processes, tree node, page, OPC UA.

READY_S = 60.0
"""Longest time that a program may take to be ready, on a slow and busy machine."""

NODE = 'tree node'
PAGE = 'operator page'
OPCUA = 'OPC UA server'

_SERVERS: Mapping[str, str] = {
    PAGE: 'open {} in a browser',
    OPCUA: f'connect an OPC UA client to {{}}: user {NAME}, password {PASSWORD}',
}
"""The operations on a server's address."""

REMEMBERED_S = 24 * 3600
"""For so long the controllers remember how a goal ended: a demo is resumed after any coffee."""


class DemoPrograms:
    """States: to be started, running, finished.

    A program that an earlier demo has left running is taken over as it is: the controllers, above
    all, which know what became of their goals.
    """

    def __init__(self, folder: DemoFolder, record: DemoRecord, resume: str) -> None:
        """Look which of them still run.

        :param resume: the command that takes over from this demo
        """
        self._folder = folder
        self._record = record
        self._resume = resume
        self._taken_over = {n: pid for n, pid in record.processes.items() if is_ours(pid)}
        self._started: dict[str, Program] = {}
        self._goes_on = False
        self._addresses: dict[str, str] = {}
        """Of the servers that were started, by name."""

    def start(self, cell: Cell) -> None:
        """Start what does not run yet, and wait until all of it is ready.

        :raises ProgramFailed: one of them ends instead
        """
        for name, verb in self._verbs(cell):
            if name in self._taken_over:
                print(f'[{self._taken_over[name]}] {name} still runs', flush=True)
                continue
            log = self._folder.path / f'{name.replace(" ", "_")}.log'
            self._started[name] = Program(verb, log, {})
            self._keep()
        if self._started:  # a slow machine is silent for a while
            print(f'starting {", ".join(self._started)}', flush=True)
        for name, program in self._started.items():
            words = program.wait_ready('ready', READY_S)
            print(f'[{program.pid}] {words}', flush=True)
            if name in _SERVERS:
                self._addresses[name] = words.split()[2]

    def about_servers(self) -> Iterator[str]:
        """Yield where page and OPC UA server are; not those of an earlier demo."""
        for name, address in self._addresses.items():
            yield _SERVERS[name].format(address)

    def about_node(self) -> str:
        """Return the number of the tree node's process, and what can be tried with it."""
        node = self._started.get(NODE)
        pid = node.pid if node else self._taken_over[NODE]
        return f'the tree node is process {pid}: try kill -9 {pid}, and then {self._resume}'

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
                f'with: {self._resume} (a new demo without --resume ends them)'
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

    def _verbs(self, cell: Cell) -> Iterator[tuple[str, list[str]]]:
        names = list(cell.components)
        halves = (names[: len(names) // 2], names[len(names) // 2 :])
        for number, half in enumerate(halves, 1):
            verb = ['sim-cell', '--cell', self._record.cell, '--speed', str(self._record.speed)]
            verb += ['--only', ','.join(half), '--result-timeout', str(REMEMBERED_S)]
            for fault in self._record.faults:
                if fault.split('.')[0].split('#')[0] in half:
                    verb += ['--fail', fault]
            yield f'controllers {number}', verb
        verb = ['run', '--cell', self._record.cell, '--executor', self._record.executor]
        verb += ['--journal', str(self._folder.journal), '--auto-resume', '--script-paths']
        trees = [f'--trees={folder}' for folder in self._record.trees]
        yield NODE, [*verb, *trees, *(['--trust-local-doors'] if self._record.stays else [])]
        if self._record.page is not None:
            journal = ['--journal', str(self._folder.journal)]
            port = ['--port', str(self._record.page)]
            account = ['--shifts', self._record.shifts, '--cell', self._record.cell]
            account = account if self._record.shifts else []
            yield PAGE, ['page', *port, '--trust-this-computer', *journal, *trees, *account]
        if self._record.opcua is not None:
            options = opcua_options(self._folder.path)
            yield OPCUA, ['opcua', '--port', str(self._record.opcua), *options, *trees]
