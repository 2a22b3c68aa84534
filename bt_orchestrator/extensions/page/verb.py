"""The verb `page`: the operator page of a running node."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import cast

from bt_orchestrator.base.extending import PAGE, POSTGRES
from bt_orchestrator.base.stop_signals import StopSignals
from bt_orchestrator.cli import bootstrap
from bt_orchestrator.cli.door import open_door, signing_key
from bt_orchestrator.cli.folders import (
    add_recipes_option,
    add_trees_option,
    recipe_folders,
    script_folders,
)
from bt_orchestrator.cli.node_options import add_node_options, user_name
from bt_orchestrator.cli.numbers import seconds
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.cli.processes.planning_process import PlanningProcess
from bt_orchestrator.cli.serving import add_server_options, server_log, users_of
from bt_orchestrator.extensions.page.web.access import IDLE_S, Access, AccessRefused
from bt_orchestrator.extensions.page.web.seams import Plant
from bt_orchestrator.model.keeping.journal_place import journal_place
from bt_orchestrator.model.plant.shifts import PlantReason
from bt_orchestrator.ports.records import PlantCells
from bt_orchestrator.script.shifts.shifts_file import read_reasons, read_shifts

DESCRIPTION = """\
Serve the operator page of a tree node, for any browser: the line as it changes, holds and their
answers, jobs, the queue. One process for each node; it may be stopped and started at any time, and
the line never notices. The node need not run yet. Ctrl-C ends it."""

ROOM = PAGE.room


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    add_access_options(parser)
    add_trees_option(parser)
    add_recipes_option(parser)
    parser.add_argument(
        '--journal',
        type=journal_place,
        metavar='FILE',
        help='journal of the node, for everything that has been; it is only read (default: what '
        'the node tells of its last events)',
    )
    add_plant_options(parser)
    add_node_options(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns the exit status."""
    PAGE.demand()
    access = access_of(args)
    from bt_orchestrator.cli.journal_file import open_records
    from bt_orchestrator.extensions.page.web.page import WebPage
    from bt_orchestrator.extensions.page.web.seams import Sources
    from bt_orchestrator.extensions.page.web.server import PageServer

    opened = partial(open_door, args.node, args.timeout, key=signing_key(args))
    journal = args.journal
    sources = Sources(
        open_records=None if journal is None else partial(open_records, journal),
        trees=script_folders(args.trees),
        recipes=recipe_folders(args.recipes),
        plant=plant_of(args),
        reasons=reasons_of(args),
        cells=cells_of(args),
        planning=PlanningProcess(script_folders(args.trees), recipe_folders(args.recipes)),
    )
    with StopSignals() as stop, server_log(ROOM):
        server = PageServer(WebPage(args.node, opened, access, sources))
        with server.running():
            print(f'page ready: {server.address} shows {args.node}', flush=True)
            stop.notify(server.stop)
            server.wait()
    return 0


# Options of the verb `page` about who reaches it, and how people are known there.


def add_access_options(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_server_options(
        parser, Access.host, PAGE.port, '; elsewhere it needs users, and TLS or a proxy'
    )
    parser.add_argument('--certificate', type=Path, metavar='FILE', help='TLS: PEM, whole chain')
    parser.add_argument('--key', type=Path, metavar='FILE', help='TLS: its key, PEM, no password')
    parser.add_argument(
        '--allow-host',
        action='append',
        default=[],
        metavar='NAME',
        help='name by which browsers call the page, besides ADDRESS and localhost; may be given '
        'several times',
    )
    parser.add_argument(
        '--trust-this-computer',
        action='store_true',
        help='whoever sits at this computer may give every command without a login: for demos',
    )
    parser.add_argument(
        '--behind-proxy',
        default='',
        metavar='HEADER',
        help='a proxy logs people in, and names them in this header; their roles are in the file '
        'of users',
    )
    parser.add_argument(
        '--proxy-address',
        action='append',
        default=[],
        metavar='IP',
        help='where the proxy is, if it is not on this computer; may be given several times',
    )
    parser.add_argument(
        '--lock-after',
        type=seconds,
        default=IDLE_S,
        metavar='SECONDS',
        help=f'a session that is not used for so long is locked (default {IDLE_S:.0f})',
    )


def access_of(args: argparse.Namespace) -> Access:
    """Return what the options say together.

    :raises WrongUse: they would let in anybody, or do not fit each other
    """
    access = Access(
        users=users_of(args),
        host=args.host,
        port=args.port,
        certificate=args.certificate,
        key=args.key,
        allowed_hosts=tuple(args.allow_host),
        local_user=user_name() if args.trust_this_computer else '',
        proxy_header=args.behind_proxy,
        proxy_addresses=tuple(args.proxy_address),
        idle_s=args.lock_after,
    )
    try:
        access.check()
    except AccessRefused as error:
        raise WrongUse(f'page: {error}') from error
    return access


# Options of the verb `page` about the shift that runs, and about the plant.


def add_plant_options(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        '--shifts',
        type=Path,
        metavar='FILE',
        help='file of shifts (YAML): the page shows OEE and losses of the shift that runs '
        '(default: it does not)',
    )
    parser.add_argument(
        '--reasons',
        type=Path,
        metavar='FILE',
        help="file of the plant's reasons for stops (YAML), which the forms offer; with --shifts "
        'stops are listed and classified',
    )
    parser.add_argument(
        '--cell',
        type=Path,
        metavar='CELL',
        help='cell file (YAML), whose durations give the pace of a shift; without it there is no '
        'performance and no OEE; without --shifts it is of no use',
    )
    parser.add_argument(
        '--plant',
        type=journal_place,
        metavar='ADDRESS',
        help='database of the plant, as postgresql://plant_reader@dbhost/plant: the page '
        'lists its cells (default: it does not)',
    )


def plant_of(args: argparse.Namespace) -> Plant | None:
    """Return what the options say together; None: no account is wanted.

    :raises Refused: a file has mistakes
    """
    if args.shifts is None:
        return None
    cell = None
    if args.cell is not None:
        cell = bootstrap.load_cell(args.cell, bootstrap.installed_types())
    return Plant(read_shifts(args.shifts), cell, reasons_of(args))


def reasons_of(args: argparse.Namespace) -> Mapping[str, PlantReason]:
    """Return the reasons of the plant; none, if their file is not named.

    :raises Refused: it has mistakes
    """
    return {} if args.reasons is None else read_reasons(args.reasons)


def cells_of(args: argparse.Namespace) -> PlantCells | None:
    """Return what reads the cells of the plant; None: none is named.

    :raises ExtensionMissing: the extension that reads its database is not installed
    """
    if args.plant is None:
        return None
    POSTGRES.demand()
    module = import_module(f'{POSTGRES.room}.overview')
    return cast('PlantCells', partial(module.cells_of, str(args.plant)))
