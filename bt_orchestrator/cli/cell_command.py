"""Commands to the cell of a running node."""

from __future__ import annotations

import argparse
import sys

from bt_orchestrator.cli.node_options import add_node_options, add_who_options


def add_command_options(parser: argparse.ArgumentParser) -> None:
    """Declare who commands, why, and which node."""
    add_who_options(parser)
    add_node_options(parser)


def command(name: str, args: argparse.Namespace) -> int:
    """Send a command; returns 1 when it was refused."""
    from bt_orchestrator_interfaces.srv import Command

    from bt_orchestrator.ros.client import NodeClient

    request = Command.Request(command=name, who=args.who, reason=args.reason)
    with NodeClient(args.node, args.timeout) as client:
        response = client.call(Command, 'command', request)
    print(response.message, file=sys.stdout if response.accepted else sys.stderr)
    return 0 if response.accepted else 1
