"""A simulated cell and its tree node in processes of their own, with a client, for tests."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml
from node_watcher import NodeWatcher
from program_process import PROGRAM, ProgramProcess

ROOT = Path(__file__).parents[1]

SPEED = 20

ACCOUNTED = 12
"""So many of the last events and goals stand in the account of a failure."""

SMALL_CELL = """
cell: small_cell
conveyor:
  sections: 2
  action: conveyor/index
  type: bt_orchestrator_interfaces/action/Conveyor
  task: MOVE_ONE_INDEX
components:
  feeder:
    {section: 1, action: feeder/task, type: bt_orchestrator_interfaces/action/Component,
     durations: {TASK_A: 1.0}}
  worker:
    section: 2
    action: worker/task
    type: bt_orchestrator_interfaces/action/Component
    state: {topic: worker/state, type: std_msgs/msg/String, field: data, ready: [READY]}
    durations: {TASK_A: 1.0, TASK_B: 1200.0, TASK_C: 40.0}
  packer:
    {section: 2, action: packer/task, type: bt_orchestrator_interfaces/action/Component,
     durations: {TASK_A: 1.0}}
"""
"""Relative names, for namespaces; a task takes 1 s of simulated time, the worker's TASK_B a
minute of real time at SPEED, and its TASK_C two seconds."""

STATELESS_CELL = '\n'.join(line for line in SMALL_CELL.splitlines() if 'state:' not in line)
"""Its worker is always ready; one with a state topic is not, as long as its server is absent."""


REMEMBERED_S = 60.0


def remembering(cell: str) -> str:
    """Return a cell whose servers know a goal for long, and not 10 s as usual, after its end.

    For nodes that are killed: on a busy machine they take more than that to start anew.
    """
    content = yaml.safe_load(cell)
    for component in (content['conveyor'], *content['components'].values()):
        component['result_timeout'] = REMEMBERED_S
    return yaml.safe_dump(content, sort_keys=False)


def small_script(name: str = 'small', options: str = '', task: str = 'TASK_A') -> str:
    """Return a script for the small cell.

    :param options: further options of the task `work`, as in `, retries: 1`
    :param task: what `work` does
    """
    return f"""
script: {name}
sections:
  1:
    - {{id: feed, task: TASK_A, action: feeder/task, qty_change: 1}}
  2:
    - {{id: work, task: {task}, action: worker/task{options}}}
    - {{id: pack, task: TASK_A, action: packer/task, qty_change: -1}}
"""


class CellProcesses:
    """Simulated controllers, tree node and client of one cell. Ends in `close`.

    :ivar sims: the processes of the simulated controllers
    :ivar node: the process of the tree node
    :ivar watch: the client
    """

    def __init__(
        self,
        folder: Path,
        cell: str = SMALL_CELL,
        *,
        fail: Sequence[str] = (),
        shares: Sequence[str] = ('',),
        namespace: str = '',
        remapped: bool = False,
        speed: float = SPEED,
        sim_options: Sequence[str] = (),
        run_options: Sequence[str] = (),
        node_program: Sequence[str] = PROGRAM,
    ) -> None:
        """Start everything; `connect` waits for it.

        :param shares: which components each process simulates, as `--only` wants it
        :param remapped: whether the namespace is given in ROS 2's way, by a remapping
        :param node_program: what Python runs as the tree node, if not the program itself
        """
        folder.mkdir(exist_ok=True)
        self.folder = folder
        self.cell = folder / 'cell.yaml'
        self.cell.write_text(cell)
        self.log = folder / 'goals.jsonl'
        spaced = ['--namespace', namespace] if namespace else []
        if remapped:
            spaced = ['--ros-args', '-r', f'__ns:={namespace}', '--']
        self._sim_words = ['sim-cell', '--cell', str(self.cell), '--log', str(self.log)]
        self._sim_words += [*spaced, '--speed', str(speed)]
        if 'result_timeout' not in cell:  # as `remembering`, of the servers alone
            self._sim_words += ['--result-timeout', str(REMEMBERED_S)]
        self._sim_words += [*sim_options, *(f'--fail={fault}' for fault in fail)]
        self._started = 0
        self.sims = [self.start_sim(share) for share in shares]
        words = ['run', '--cell', str(self.cell), '--trees', str(folder), *spaced]
        self._node_words = [*words, *run_options]
        self.node = ProgramProcess(self._node_words, folder, 'node', node_program)
        self.watch = NodeWatcher(f'{namespace}/bt_orchestrator')

    def start_sim(self, share: str = '', program: Sequence[str] = PROGRAM) -> ProgramProcess:
        """Start simulated controllers in a further process."""
        only = ['--only', share] if share else []
        self._started += 1
        name = f'sim_{self._started}_{share.replace(",", "_") or "all"}'
        return ProgramProcess([*self._sim_words, *only], self.folder, name, program)

    def kill_and_restart_node(self) -> None:
        """Kill the node as kill -9 does, and start it again."""
        self.node.kill()
        self.start_node()
        self.node.wait_ready()

    def start_node(self, program: Sequence[str] = PROGRAM, options: Sequence[str] = ()) -> None:
        """Start the node again, which must be gone.

        :param program: what Python runs, if not the program itself
        :param options: of `run`, on top of those that it always has
        """
        self.node = ProgramProcess([*self._node_words, *options], self.folder, 'node', program)

    def start_beside(
        self, name: str, options: Sequence[str] = (), program: Sequence[str] = PROGRAM
    ) -> ProgramProcess:
        """Start another node of the cell, for instance a standby; the caller ends it.

        :param options: of `run`, on top of those of the node
        """
        return ProgramProcess([*self._node_words, *options], self.folder, name, program)

    def connect(self, *, wait_servers: bool = True) -> None:
        """Wait until everything is up and knows of each other."""
        for process in (*self.sims, self.node):
            process.wait_ready()
        self.watch.connect(wait_servers=wait_servers)

    def script(self, text: str, name: str = 'small') -> Path:
        """Write a script, which the node also finds by name."""
        path = self.folder / f'{name}.yaml'
        path.write_text(text)
        return path

    def run_small(
        self, options: str = '', task: str = 'TASK_A', *, quantity: int = 1, order: str = 'WO-1'
    ) -> None:
        """Submit an order for the small script."""
        self.watch.submit(
            self.script(small_script(options=options, task=task)), quantity=quantity, order=order
        )

    def verb(self, *words: str) -> tuple[int, str, str]:
        """Carry out a verb, hearing meanwhile what the node says; see `run_verb`."""
        process = ProgramProcess(words, self.folder, f'verb_{words[0]}')
        self.watch.ros.spin_until(lambda: not process.is_running, f'the end of {words}')
        return _ended(process)

    def goals(self, **about: Any) -> list[Mapping[str, Any]]:
        """Return what really happened to goals, of the records with these values."""
        lines = self.log.read_text().splitlines() if self.log.exists() else []
        return [r for line in lines if about.items() <= (r := json.loads(line)).items()]

    def child(self, module: str) -> int:
        """Return the process of a module that the node has started, once it is there."""
        matches: list[int] = []

        def look() -> bool:
            children = Path(f'/proc/{self.node.pid}/task').glob('*/children')
            pids = [int(pid) for path in children for pid in path.read_text().split()]
            matches[:] = [pid for pid in pids if runs(pid, module)]
            return bool(matches)

        self.watch.ros.spin_until(look, f'the process {module}')
        return matches[0]

    def account(self) -> str:
        """Say how everything stands, for whoever reads of a failure: what waits, and for what."""
        watch, node = self.watch, self.node
        gone = '' if node.is_running else 'the node has ended\n'
        _, status, errors = run_verb(self.folder, 'status', '--node', watch.name)
        heard = watch.statuses[-1].seq if watch.statuses else 'none'
        events = '\n'.join(map(json.dumps, watch.events[-ACCOUNTED:]))
        goals = '\n'.join(map(json.dumps, self.goals()[-ACCOUNTED:]))
        return (
            f'{gone}{status}{errors}'
            f'the client heard of the status at seq {heard}, and these events last:\n{events}\n'
            f'the controllers wrote last:\n{goals}\nthe node wrote:\n{node.errors[-4000:]}'
        )

    def stop(self, node_status: int = 0) -> None:
        """End everything, node first, and fail unless all of it ends well."""
        assert self.node.stop() == node_status, self.node.errors
        self.node.assert_clean()
        for sim in self.sims:
            assert sim.stop() == 0, sim.errors
            sim.assert_clean()

    def close(self) -> None:
        """Leave nothing behind, whatever happened."""
        for process in (self.node, *self.sims):
            process.kill()
        self.watch.close()


StartCell = Callable[..., CellProcesses]
"""A fixture's function with the arguments of `CellProcesses`, but for `folder`: a name."""


def run_verb(folder: Path, *words: str) -> tuple[int, str, str]:
    """Carry out a verb and return exit status, output, and errors."""
    return _ended(ProgramProcess(words, folder, f'verb_{words[0]}'))


def _ended(verb: ProgramProcess) -> tuple[int, str, str]:
    status = verb.wait()
    assert 'Traceback' not in verb.errors, verb.errors
    return status, verb.output, verb.errors


def runs(pid: int, module: str) -> bool:
    """Tell whether a process is there and runs a module."""
    try:
        return module.encode() in Path(f'/proc/{pid}/cmdline').read_bytes().split(b'\0')
    except FileNotFoundError:
        return False
