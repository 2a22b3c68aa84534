"""The verb `demo`: a simulated cell, the tree node and one order, from nothing to the summary."""

from __future__ import annotations

import argparse
import json
import os
import random
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from bt_orchestrator.cli.bootstrap import installed_types, load_cell
from bt_orchestrator.cli.demo_folder import DemoFolder, DemoRecord, default_folder
from bt_orchestrator.cli.demo_programs import READY_S, DemoPrograms
from bt_orchestrator.cli.folders import add_trees_option, shipped
from bt_orchestrator.cli.forecast_text import forecast_lines
from bt_orchestrator.cli.numbers import factor
from bt_orchestrator.cli.programs import ProgramFailed
from bt_orchestrator.cli.submit import submit
from bt_orchestrator.cli.watch import follow, live_or, say
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.codec import from_record
from bt_orchestrator.model.events import CellStateChanged, Event, JobAborted, JobCompleted
from bt_orchestrator.model.order import WorkOrder
from bt_orchestrator.screen.plain import EventLines
from bt_orchestrator.screen.words import DEFAULT_NODE, hold_text
from bt_orchestrator.script.order_file import read_order
from bt_orchestrator.sim.forecast_fold import forecast
from bt_orchestrator.stop_signals import StopSignals
from bt_orchestrator.store.reader import JournalReader, Wanted

DESCRIPTION = """\
Show the whole path on this machine: simulated controllers in two processes, the tree node in a
third, one work order, progress as it happens, and a summary. Needs no cell and no robot;
everything it starts is gone when it ends. A demo that was killed, or whose tree node was, leaves
its controllers at work, as on a real line, and goes on with --resume."""

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
        type=factor,
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
    parser.add_argument(
        '--resume',
        action='store_true',
        help='take over from a demo that was killed: its journal, its controllers, its order',
    )
    parser.add_argument(
        '--folder',
        type=Path,
        metavar='DIR',
        help='where the journal and the logs are (default: ~/.local/state/bt_orchestrator/demo)',
    )


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; 0 when every item was packed."""
    with ExitStack() as stack:
        stop = stack.enter_context(StopSignals())
        folder = stack.enter_context(DemoFolder(args.folder or default_folder()))
        record = folder.left() if args.resume else _begin(args, folder)
        cell = load_cell(Path(record.cell), installed_types())
        os.environ['ROS_DOMAIN_ID'] = record.domain
        os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
        print(f'demo in ROS_DOMAIN_ID={record.domain}')
        programs = DemoPrograms(folder, record)
        try:
            programs.start(args, cell)
            return _show(folder, record, programs, stop)
        finally:
            programs.finish()


def _begin(args: argparse.Namespace, folder: DemoFolder) -> DemoRecord:
    """Make room for a new demo, which keeps to itself.

    Another ROS graph may have action servers of the same names, hence the domain.
    """
    folder.begin()
    cell = args.cell or shipped('config', 'reference_cell.yaml')
    order = args.order or shipped('config', 'orders', 'wo_1001.yaml')
    domain = os.environ.get('ROS_DOMAIN_ID') or str(random.randint(1, 101))
    return DemoRecord(domain, str(cell.resolve()), str(order.resolve()))


def _show(
    folder: DemoFolder, record: DemoRecord, programs: DemoPrograms, stop: StopSignals
) -> int:
    """Submit the order unless it is there, follow it to its end, and sum up."""
    from bt_orchestrator.ros.client import NodeClient

    events: list[Event] = []
    with NodeClient(DEFAULT_NODE, READY_S) as client:
        statuses: list[Any] = []
        client.on_status(statuses.append)
        _wait_for_servers(client, statuses, stop)
        with live_or(lambda: EventLines(say), DEFAULT_NODE) as viewer:
            follow(client, viewer, events.append)
            job = _job(client, statuses, read_order(Path(record.order)).order)
            while not stop.requested and not _is_over(events, statuses[-1], job):
                programs.check()
                client.spin()
                viewer.refresh()
    for hold in statuses[-1].holds:
        say(hold_text(hold))
    if stop.requested:
        say('interrupted: stopping everything that was started')
        return INTERRUPTED
    return _sum_up(folder, load_cell(Path(record.cell), installed_types()), job)


def _job(client: Any, statuses: Sequence[Any], order: WorkOrder) -> str:
    """Return the id of the order's job, which a resumed demo has already."""
    known = {job.id for job in statuses[-1].jobs}
    if order.order is not None and order.order in known:
        return order.order
    answer = submit(client, order)
    if not answer.accepted:
        raise ProgramFailed('\n'.join([answer.message, *answer.findings]))
    return str(answer.job)


def _wait_for_servers(client: Any, statuses: Sequence[Any], stop: StopSignals) -> None:
    """Wait until the node sees every action server."""
    client.wait_until(
        lambda: stop.requested or (statuses and all(c.available for c in statuses[-1].components)),
        'every action server at the node',
    )


def _is_over(events: Sequence[Event], status: Any, job: str) -> bool:
    """Tell whether the job has ended, or nothing goes on without an operator."""
    ended = any(isinstance(e, JobCompleted | JobAborted) and e.job == job for e in events[-20:])
    over = any(j.id == job and j.state in ('Ended', 'Aborted') for j in status.jobs)
    states = (e.state for e in reversed(events) if isinstance(e, CellStateChanged))
    return ended or over or next(states, status.state) == 'Held'


def _sum_up(folder: DemoFolder, cell: Cell, job: str) -> int:
    with JournalReader(folder.journal) as journal:
        records = [json.loads(text) for _, text in journal.records(Wanted())]
    result = forecast([from_record(record) for record in records], cell)
    print()
    for line in forecast_lines(result):
        print(line)
    print(f'journal: {folder.journal}')
    done = next((j for j in result.jobs if j.job == job), None)
    return 0 if done is not None and done.packed == done.quantity else 1
