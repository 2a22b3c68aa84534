"""Options of the verbs that serve a node at an address, to people or programs who log in."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from bt_orchestrator.cli.numbers import port
from bt_orchestrator.script.users.file import default_file


def add_server_options(
    parser: argparse.ArgumentParser, this_computer: str, usual_port: int, elsewhere: str = ''
) -> None:
    """Declare where it listens, and who may log in.

    :param this_computer: address that no other computer reaches
    :param elsewhere: what it needs at an address that other computers reach
    """
    parser.add_argument(
        '--host',
        default=this_computer,
        metavar='ADDRESS',
        help=f'address to listen at (default {this_computer}: this computer alone){elsewhere}',
    )
    parser.add_argument(
        '--port',
        type=port,
        default=usual_port,
        metavar='PORT',
        help=f'default {usual_port}; 0: any free one',
    )
    parser.add_argument(
        '--users',
        type=Path,
        metavar='FILE',
        help='file of users (default: ~/.config/bt_orchestrator/users.yaml); see `user`',
    )


def users_of(args: argparse.Namespace) -> Path:
    """Return the file of users that is meant."""
    found: Path = args.users or default_file(os.environ)
    return found
