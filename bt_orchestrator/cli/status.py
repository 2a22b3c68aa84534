"""The verb `status`: how a running node's cell stands."""

from __future__ import annotations

import argparse
import json

from bt_orchestrator.cli.node_options import add_node_options
from bt_orchestrator.model.codec import to_plain
from bt_orchestrator.screen.advice import Shell
from bt_orchestrator.screen.words import status_lines


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = 'Print how the cell of a running tree node stands.'
    parser.add_argument('--json', action='store_true', help='the whole status as one JSON object')
    add_node_options(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns the exit status."""
    from bt_orchestrator.ros.link.client import NodeClient

    with NodeClient(args.node, args.timeout) as client:
        status = client.status()
    if args.json:
        print(json.dumps(to_plain(status, whole=True)))
    else:
        print('\n'.join(status_lines(status, Shell(args.node))))
    return 0
