"""The verb `demo`: a simulated cell, the tree node and one order, from nothing to the summary."""

from __future__ import annotations

import argparse
import os
import random
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from bt_orchestrator.cli.bootstrap import installed_types, load_cell
from bt_orchestrator.cli.folders import add_trees_option, shipped
from bt_orchestrator.cli.forecast_text import forecast_lines
from bt_orchestrator.cli.programs import Program, ProgramFailed
from bt_orchestrator.cli.submit import submit
from bt_orchestrator.cli.watch import follow, live_or, say
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.events import CellStateChanged, Event, JobAborted, JobCompleted
from bt_orchestrator.screen.plain import EventLines
from bt_orchestrator.screen.words import DEFAULT_NODE, hold_text
from bt_orchestrator.script.order_file import read_order
from bt_orchestrator.sim.forecast_fold import forecast
from bt_orchestrator.stop_signals import StopSignals

DESCRIPTION = """\
Show the whole path on this machine: simulated controllers in two processes, the tree node in a
third, one work order, progress as it happens, and a summary. Needs no cell and no robot;
everything it starts is gone when it ends."""

READY_S = 60.0
"""Longest time that a program may take to be ready, on a slow and busy machine."""

INTERRUPTED = 130


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.add_argument('--cell', type=Path, metavar='CELL', help='cell file (default: shipped)')
    parser.add_argument(
        '--order', type=Path, metavar='ORDER', help='work order (default: the shipped WO-1001)'
    )
    add_trees_option(parser)
    parser.add_argument(
        '--speed',
        type=float,
        default=4.0,
        metavar='N',
        help='divide all simulated seconds by N (default 4)',
    )
    parser.add_argument(
        '--fail',
        action='append',
        default=[],
        metavar='COMPONENT.FAULT',
        help='make a component fail; see `sim-cell --help`',
    )
    parser.add_argument(
        '--executor',
        choices=('single', 'events'),
        default='single',
        help='executor of the tree node',
    )


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; 0 when every item was packed."""
    args.cell = args.cell or shipped('config', 'reference_cell.yaml')
    args.order = args.order or shipped('config', 'orders', 'wo_1001.yaml')
    cell = load_cell(args.cell, installed_types())
    _choose_domain()
    with ExitStack() as stack:
        stop = stack.enter_context(StopSignals())
        folder = Path(stack.enter_context(_log_folder()))
        _start(stack, args, cell, folder)
        return _show(args, cell, stop)


def _choose_domain() -> None:
    """Keep the demo to itself: another ROS graph may have action servers of the same names."""
    if 'ROS_DOMAIN_ID' not in os.environ:
        os.environ['ROS_DOMAIN_ID'] = str(random.randint(1, 101))
    os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    print(f'demo in ROS_DOMAIN_ID={os.environ["ROS_DOMAIN_ID"]}')


@contextmanager
def _log_folder() -> Iterator[str]:
    """Keep what the programs say; the folder stays only when something failed."""
    with tempfile.TemporaryDirectory(prefix='bt_orchestrator_demo_') as folder:
        yield folder


def _start(stack: ExitStack, args: argparse.Namespace, cell: Cell, folder: Path) -> None:
    names = list(cell.components)
    halves = (names[: len(names) // 2], names[len(names) // 2 :])
    programs = []
    for number, half in enumerate(halves, 1):
        verb = ['sim-cell', '--cell', str(args.cell), '--speed', str(args.speed)]
        verb += ['--only', ','.join(half)]
        for fault in args.fail:
            if fault.split('.')[0].split('#')[0] in half:
                verb += ['--fail', fault]
        programs.append(_started(stack, verb, folder / f'sim_cell_{number}.log'))
    verb = ['run', '--cell', str(args.cell), '--executor', args.executor]
    for trees in args.trees:
        verb += ['--trees', str(trees)]
    programs.append(_started(stack, verb, folder / 'tree_node.log'))
    for program in programs:
        line = program.wait_ready('ready', READY_S)
        print(f'[{program.pid}] {line}', flush=True)


def _started(stack: ExitStack, verb: list[str], log: Path) -> Program:
    program = Program(verb, log, {})
    stack.callback(program.stop)
    return program


def _show(args: argparse.Namespace, cell: Cell, stop: StopSignals) -> int:
    """Submit the order, follow it to its end, and sum up."""
    from bt_orchestrator.ros.client import NodeClient

    events: list[Event] = []
    with NodeClient(DEFAULT_NODE, READY_S) as client:
        statuses: list[Any] = []
        client.on_status(statuses.append)
        _wait_for_servers(client, statuses, stop)
        with live_or(lambda: EventLines(say), DEFAULT_NODE) as viewer:
            follow(client, viewer, events.append)
            answer = submit(client, read_order(args.order).order)
            if not answer.accepted:
                raise ProgramFailed('\n'.join([answer.message, *answer.findings]))
            while not stop.requested and not _is_over(events, answer.job):
                client.spin()
                viewer.refresh()
    for hold in statuses[-1].holds:
        say(hold_text(hold))
    if stop.requested:
        say('interrupted: stopping everything that was started')
        return INTERRUPTED
    return _sum_up(events, cell, answer.job)


def _wait_for_servers(client: Any, statuses: Sequence[Any], stop: StopSignals) -> None:
    """Wait until the node sees every action server."""
    client.wait_until(
        lambda: stop.requested or (statuses and all(c.available for c in statuses[-1].components)),
        'every action server at the node',
    )


def _is_over(events: Sequence[Event], job: str) -> bool:
    """Tell whether the job has ended, or nothing goes on without an operator."""
    ended = any(isinstance(e, JobCompleted | JobAborted) and e.job == job for e in events[-20:])
    states = (e.state for e in reversed(events) if isinstance(e, CellStateChanged))
    return ended or next(states, '') == 'Held'


def _sum_up(events: list[Event], cell: Cell, job: str) -> int:
    result = forecast(events, cell)
    print()
    for line in forecast_lines(result):
        print(line)
    done = next((j for j in result.jobs if j.job == job), None)
    return 0 if done is not None and done.packed == done.quantity else 1
