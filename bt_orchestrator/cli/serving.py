"""Options and output of the verbs that serve a node at an address."""

from __future__ import annotations

import argparse
import logging
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from bt_orchestrator.cli.node_options import add_key_option
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
    add_key_option(parser)


def users_of(args: argparse.Namespace) -> Path:
    """Return the file of users that is meant."""
    path: Path = args.users or default_file(os.environ)
    return path


# The output of a server while it runs: one line for each login, command and error.


@contextmanager
def server_log(room: str) -> Iterator[None]:
    """Write to the standard error as long as the context is open.

    :param room: package whose log is written
    """
    log, handler = logging.getLogger(room), logging.StreamHandler(sys.stderr)
    handler.setFormatter(OneLine('%(asctime)s %(levelname)s %(message)s'))
    level = log.level
    log.setLevel(logging.INFO)
    log.addHandler(handler)
    try:
        yield
    finally:
        log.removeHandler(handler)
        log.setLevel(level)


class OneLine(logging.Formatter):
    """Keeps what others have written from looking like lines of the server."""

    def formatMessage(self, record: logging.LogRecord) -> str:  # noqa: N802 - of the base
        """Return the line; a traceback may follow."""
        return ''.join(
            char if char.isprintable() else repr(char)[1:-1]
            for char in super().formatMessage(record)
        )
