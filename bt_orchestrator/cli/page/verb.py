"""The verb `page`: the operator page of a running node."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from contextlib import AbstractContextManager

from bt_orchestrator.cli.door import open_door
from bt_orchestrator.cli.node_options import add_node_options
from bt_orchestrator.ports import CellLink
from bt_orchestrator.stop_signals import StopSignals

DESCRIPTION = """\
Serve the operator page of a tree node, for any browser: the line as it changes, holds and their
answers, jobs, the queue. One process for each node; it may be stopped and started at any time, and
the line never notices. The node need not run yet. Ctrl-C ends it."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.add_argument(
        '--host',
        default='127.0.0.1',
        metavar='ADDRESS',
        help='address to listen at (default 127.0.0.1: this computer alone)',
    )
    parser.add_argument(
        '--port', type=_port, default=8080, metavar='PORT', help='default 8080; 0: any free one'
    )
    parser.add_argument(
        '--trust-this-computer',
        action='store_true',
        help='whoever sits at this computer may give commands without a login: for demos',
    )
    add_node_options(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns the exit status."""
    from bt_orchestrator.web.page import Page, PageOptions
    from bt_orchestrator.web.server import PageServer

    def opened(meanwhile: Callable[[], object]) -> AbstractContextManager[CellLink]:
        return open_door(args.node, args.timeout, meanwhile)

    options = PageOptions(args.host, args.port, args.trust_this_computer)
    with StopSignals() as stop:
        server = PageServer(Page(args.node, opened, options))
        with server.running():
            print(f'page of {args.node}: {server.address}', flush=True)
            stop.notify(server.stop)
            server.wait()
    return 0


def _port(text: str) -> int:
    """Read the number of a port.

    :raises ArgumentTypeError: it is none
    """
    if not (text.isascii() and text.isdecimal() and len(text) < 6 and int(text) <= 65535):
        raise argparse.ArgumentTypeError(f'expected a port from 0 to 65535, found {text!r}')
    return int(text)
