"""The verb `demo`: a simulated cell, the tree node and one order, from nothing to the summary."""

from __future__ import annotations

import argparse
import json
import os
import random
import shlex
import shutil
import sys
from collections.abc import Sequence
from contextlib import ExitStack, closing
from itertools import dropwhile
from pathlib import Path
from typing import Any

from bt_orchestrator.base.extending import OPCUA, PAGE
from bt_orchestrator.base.stop_signals import StopSignals
from bt_orchestrator.cli.bootstrap import installed_types, load_cell
from bt_orchestrator.cli.demo.folder import DemoFolder, DemoRecord, default_folder
from bt_orchestrator.cli.demo.programs import READY_S, DemoPrograms
from bt_orchestrator.cli.demo.show import DemoShow, Dialogue, Interrupted
from bt_orchestrator.cli.door import open_door
from bt_orchestrator.cli.folders import add_trees_option, shipped
from bt_orchestrator.cli.journal_file import open_records
from bt_orchestrator.cli.numbers import factor, port
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.cli.watch import live_or, say
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.codec import from_record
from bt_orchestrator.model.events import JobQueued
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.script.orders.order_file import read_order
from bt_orchestrator.script.shifts.shifts_file import read_shifts
from bt_orchestrator.sim.controllers.options import WrongSelection, select
from bt_orchestrator.view.report.forecast_fold import forecast
from bt_orchestrator.view.report.forecast_text import detail_lines, summary_lines
from bt_orchestrator.view.report.reading import Reading
from bt_orchestrator.view.screen.advice import DEFAULT_NODE, PROGRAM, Shell
from bt_orchestrator.view.screen.keys import keys_of_person
from bt_orchestrator.view.screen.plain import EventLines
from bt_orchestrator.view.screen.words import hold_text

DESCRIPTION = """\
Show the whole path on this machine: two processes of simulated controllers, the tree node, one
work order, its progress, and a summary. Needs no cell and no robot, and ends all that
it started. A hold is answered with a key, or with the command that
is printed. A demo that was killed, or whose tree node was, leaves its controllers at work, as on a
real line, and goes on with --resume."""

INTERRUPTED = 130


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    _add_line(parser)
    _add_doors(parser)
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


def _add_line(parser: argparse.ArgumentParser) -> None:
    """Declare what runs, how fast, and what fails."""
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
        '--on-hold',
        choices=('ask', 'end'),
        default='ask',
        help='what a hold does: wait for its answer (default), or end the demo with exit status 1',
    )


def _add_doors(parser: argparse.ArgumentParser) -> None:
    """Declare who else sees the cell."""
    parser.add_argument(
        '--page',
        nargs='?',
        type=port,
        const=PAGE.port,
        metavar='PORT',
        help=f'serve the operator page as well, on this computer (default port {PAGE.port}), and '
        'go on after the order, until Ctrl-C',
    )
    parser.add_argument(
        '--shifts',
        type=Path,
        metavar='FILE',
        help='with --page: file of shifts, for OEE and losses of the shift that runs; the pace is '
        'that of --speed 1',
    )
    parser.add_argument(
        '--opcua',
        nargs='?',
        type=port,
        const=OPCUA.port,
        metavar='PORT',
        help='serve OPC UA clients as well, on this computer and without encryption '
        f'(default port {OPCUA.port}), and go on after the order, until Ctrl-C',
    )


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; 0 when every item was packed."""
    with ExitStack() as stack:
        stop = stack.enter_context(StopSignals())
        types = installed_types()
        new = None if args.resume else _checked(args, types)
        folder = stack.enter_context(DemoFolder(args.folder or default_folder()))
        if new is not None:
            folder.begin()
        record = folder.left() if new is None else new
        domain = f'ROS_DOMAIN_ID={record.domain}'
        is_set = os.environ.get('ROS_DOMAIN_ID') == record.domain
        shell = Shell(program=called_as() if is_set else f'{domain} {called_as()}')
        os.environ['ROS_DOMAIN_ID'] = record.domain
        print(f'demo in {domain}')
        programs = DemoPrograms(folder, record, _resume(args))
        try:
            programs.start(load_cell(Path(record.cell), types))
            job, holds = _show(programs, record, shell, stop, asks=args.on_hold == 'ask')
        except Interrupted:
            say('interrupted: stopping everything that was started')
            return INTERRUPTED
        finally:
            programs.finish()
        for hold in holds:
            say(hold_text(hold))
        return _sum_up(folder, load_cell(Path(record.cell), types), job)


def _checked(args: argparse.Namespace, types: ActionTypes) -> DemoRecord:
    """Return the parts of a new demo, which does not interfere with other nodes.

    Another ROS graph may have action servers of the same names, hence the domain.

    :raises OrchestratorError: a file or a fault is wrong; nothing has been started yet
    """
    for extension, port_asked in ((PAGE, args.page), (OPCUA, args.opcua)):
        if port_asked is not None:
            extension.demand()
    path = args.cell or shipped('config', 'reference_cell.yaml')
    order = args.order or shipped('config', 'orders', 'wo_1001.yaml')
    try:
        select(load_cell(path, types), (), args.fail, types)
    except WrongSelection as error:
        raise WrongUse(str(error)) from error
    read_order(order)
    if args.shifts is not None:
        read_shifts(args.shifts)
    return DemoRecord(
        domain=os.environ.get('ROS_DOMAIN_ID') or str(random.randint(1, 101)),
        cell=str(path.resolve()),
        order=str(order.resolve()),
        speed=args.speed,
        faults=args.fail,
        trees=[str(folder.resolve()) for folder in args.trees],
        executor=args.executor,
        page=args.page,
        shifts='' if args.shifts is None else str(args.shifts.resolve()),
        opcua=args.opcua,
    )


def _resume(args: argparse.Namespace) -> str:
    """Return the command that takes over from this demo."""
    folder = f' --folder {shlex.quote(str(args.folder))}' if args.folder else ''
    return f'{verb_as("demo")} --resume{folder}'


def _show(
    programs: DemoPrograms, record: DemoRecord, shell: Shell, stop: StopSignals, *, asks: bool
) -> tuple[str, Sequence[Any]]:
    """Show the order from its submission to its end.

    :param asks: a hold waits for its answer; otherwise it ends the demo
    :return: the id of its job, and what is held
    :raises ProgramFailed: the tree node has gone
    :raises Interrupted: somebody wants an end
    """
    with ExitStack() as stack:
        viewer = stack.enter_context(live_or(lambda: EventLines(shell, say), shell))
        is_asked = asks and sys.stdout.isatty()
        keys = stack.enter_context(keys_of_person()) if is_asked else None
        dialogue = stack.enter_context(Dialogue(shell, keys))
        show = DemoShow(programs, viewer, dialogue, stop)
        door = stack.enter_context(open_door(DEFAULT_NODE, READY_S, show.look))
        order = read_order(Path(record.order)).order
        return show.follow(door, order, asks=asks, stays=record.stays)


def _sum_up(folder: DemoFolder, cell: Cell, job: str) -> int:
    with closing(open_records(folder.journal)) as journal:
        records = [json.loads(record.text) for record in Reading(journal).each(Wanted())]
    events = (from_record(record) for record in records)
    # As the lines before it, the summary counts from the order on, and not from the node's start.
    result = forecast(dropwhile(lambda event: not isinstance(event, JobQueued), events), cell)
    print()
    for line in (*summary_lines(result), '', *detail_lines(result)):
        print(line)
    print(f'journal: {folder.journal}')
    done = next((j for j in result.jobs if j.job == job), None)
    return 0 if done is not None and done.packed == done.quantity else 1


# The words that call this program again, in the shell and folder it was called in.

WRAPPER = 'BT_ORCHESTRATOR_CALLED_AS'
"""Variable in which a script that calls a verb says how it was called itself."""


def called_as() -> str:
    """Return the words for this program that work where the reader stands."""
    program = Path(sys.argv[0])
    if program.name != PROGRAM:  # python -m
        program = Path(sys.executable).with_name(PROGRAM)
    if not program.exists():
        return f'{shlex.quote(sys.executable)} -m bt_orchestrator'
    executable = shutil.which(PROGRAM)
    if executable is not None and Path(executable).samefile(program):
        return PROGRAM
    path = program.absolute()
    here = Path.cwd()
    return shlex.quote(str(path.relative_to(here) if path.is_relative_to(here) else path))


def verb_as(verb: str) -> str:
    """Return the words for a verb; those of the script that called it, if one did."""
    return os.environ.get(WRAPPER) or f'{called_as()} {verb}'
