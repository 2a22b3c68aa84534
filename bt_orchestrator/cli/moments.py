"""Moments and periods on the command line."""

from __future__ import annotations

import argparse
from datetime import datetime

EARLIEST, LATEST = 1900, 2999
"""Years; in any time zone, and on a clock that was not set."""


def moment(text: str) -> float:
    """Return seconds since the epoch of a time as people write it.

    :raises ArgumentTypeError: it is no time
    """
    try:
        found = datetime.fromisoformat(text)
        if not EARLIEST <= found.year <= LATEST:
            raise ValueError(f'{found.year} is no year of a line')
        return found.timestamp()
    except ValueError as error:
        raise argparse.ArgumentTypeError(
            f'{text!r} is not a time; write 2026-05-17, or 2026-05-17T14:30, with +02:00 or '
            'without'
        ) from error


def add_period_options(parser: argparse.ArgumentParser, what: str) -> None:
    """Declare `--from` and `--to`, which become `since` and `until`.

    :param what: what they choose, to begin their help
    """
    parser.add_argument(
        '--from',
        dest='since',
        type=moment,
        metavar='TIME',
        help=f'{what} from this time on, for instance 2026-05-17T14:30',
    )
    parser.add_argument(
        '--to', dest='until', type=moment, metavar='TIME', help=f'{what} up to this time'
    )
