"""Options of the verbs that talk to a running tree node."""

from __future__ import annotations

import argparse
import getpass
import os
import socket
from pathlib import Path

from bt_orchestrator.cli.numbers import node_name, seconds
from bt_orchestrator.view.screen.advice import DEFAULT_NODE, PROGRAM


def add_node_options(parser: argparse.ArgumentParser) -> None:
    """Declare which node is meant and how long to wait for it."""
    parser.add_argument(
        '--node',
        type=node_name,
        default=DEFAULT_NODE,
        metavar='NAME',
        help=f'full name of the tree node (default {DEFAULT_NODE})',
    )
    parser.add_argument(
        '--timeout',
        type=seconds,
        default=5.0,
        metavar='SECONDS',
        help='longest time to wait for the node (default 5)',
    )


def add_who_options(parser: argparse.ArgumentParser, *, required: bool = True) -> None:
    """Declare who decides, and why."""
    parser.add_argument('--reason', required=required, metavar='TEXT', help='why, for the record')
    parser.add_argument(
        '--who', default=user_name(), metavar='NAME', help='who decides (default: you)'
    )
    add_key_option(parser)


KEY_VARIABLE = 'BT_ORCHESTRATOR_KEY'


def add_key_option(parser: argparse.ArgumentParser) -> None:
    """Declare which key signs requests."""
    parser.add_argument(
        '--sign-with',
        type=Path,
        metavar='FILE',
        help='private key that signs the requests, made by `user key` (default: what '
        f'{KEY_VARIABLE} names, else they go unsigned)',
    )


def origin() -> str:
    """Say where a command comes from: this program on this computer, and over which terminal."""
    over = os.environ.get('SSH_CONNECTION', '').partition(' ')[0]
    return f'{PROGRAM} at {socket.gethostname()}{f" from {over}" if over else ""}'


# The name of the user of this program.


def user_name() -> str:
    """Return the login name of the user; in a container the user id may have none."""
    try:
        name = getpass.getuser()
    except (ImportError, KeyError, OSError):
        return f'user {os.getuid()}'
    return name.encode(errors='replace').decode()
