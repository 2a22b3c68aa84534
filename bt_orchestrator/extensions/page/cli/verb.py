"""The verb `page`: the operator page of a running node."""

from __future__ import annotations

import argparse
from functools import partial

from bt_orchestrator.base.extending import PAGE
from bt_orchestrator.base.stop_signals import StopSignals
from bt_orchestrator.cli.door import open_door
from bt_orchestrator.cli.folders import (
    add_recipes_option,
    add_trees_option,
    recipe_folders,
    script_folders,
)
from bt_orchestrator.cli.node_options import add_node_options
from bt_orchestrator.cli.processes.planning_process import PlanningProcess
from bt_orchestrator.cli.server_log import server_log
from bt_orchestrator.extensions.page.cli.access_options import access_of, add_access_options
from bt_orchestrator.extensions.page.cli.plant_options import add_plant_options, cells_of, plant_of
from bt_orchestrator.model.keeping.journal_place import journal_place

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

    opened = partial(open_door, args.node, args.timeout)
    journal = args.journal
    sources = Sources(
        open_records=None if journal is None else partial(open_records, journal),
        trees=script_folders(args.trees),
        recipes=recipe_folders(args.recipes),
        plant=plant_of(args),
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
