"""The verb `events`: what happens at a running node, as it happens."""

from __future__ import annotations

import argparse
from typing import Any

from bt_orchestrator.cli.node_options import add_node_options
from bt_orchestrator.stop_signals import StopSignals


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = (
        'Print every event of a running tree node from now on, one JSON object a line, until '
        'Ctrl-C.'
    )
    parser.add_argument('--count', type=int, metavar='N', help='end after N events')
    add_node_options(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns the exit status."""
    from bt_orchestrator.ros.client import NodeClient

    printed = 0

    def show(message: Any) -> None:
        nonlocal printed
        if args.count is None or printed < args.count:
            print(message.record, flush=True)
            printed += 1

    with StopSignals() as stop, NodeClient(args.node, args.timeout) as client:
        client.on_event(show)
        while not stop.requested and (args.count is None or printed < args.count):
            client.spin()
    return 0
