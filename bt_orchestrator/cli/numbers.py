"""Numbers, moments and periods on the command line."""

from __future__ import annotations

import argparse
import math
import re
from datetime import datetime

from bt_orchestrator.script.ros_names import NAME_FORM

EARLIEST, LATEST = 1900, 2999
"""Years; in any time zone, and on a clock that was not set."""


def moment(text: str) -> float:
    """Return seconds since the epoch of a time as people write it.

    :raises ArgumentTypeError: it is no time
    """
    try:
        instant = datetime.fromisoformat(text)
        if not EARLIEST <= instant.year <= LATEST:
            raise ValueError(f'{instant.year} is no year of a line')
        return instant.timestamp()
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


LARGEST, LARGEST_32 = 2**63 - 1, 2**32 - 1
"""The range of a number in a journal, and of a quantity or a place in a request."""

LONGEST_S = 1e9
"""Thirty years: as good as no limit, and any clock can still add it."""


def whole(text: str, largest: int = LARGEST) -> int:
    """Read a count or a sequence number, from 0.

    :raises ArgumentTypeError: it is none, or too large
    """
    digits = text.isascii() and text.isdecimal() and len(text) < 20
    if not digits or int(text) > largest:
        raise argparse.ArgumentTypeError(
            f'expected a whole number from 0 to {largest}, found {text!r}'
        )
    return int(text)


def whole_32(text: str) -> int:
    """Read a quantity or a place in the queue; 0 where none is meant.

    :raises ArgumentTypeError: it is none, or too large
    """
    return whole(text, LARGEST_32)


def seconds(text: str) -> float:
    """Read seconds, from 0.

    :raises ArgumentTypeError: they are none
    """
    number = _finite(text)
    if not 0 <= number <= LONGEST_S:
        raise argparse.ArgumentTypeError(f'expected seconds, 0 or more, found {text!r}')
    return number


def factor(text: str) -> float:
    """Read a number that durations can be divided by.

    :raises ArgumentTypeError: it is none
    """
    number = _finite(text)
    if not 0 < number <= LONGEST_S:
        raise argparse.ArgumentTypeError(f'expected a number greater than 0, found {text!r}')
    return number


def node_name(text: str) -> str:
    """Read the full name of a node.

    :raises ArgumentTypeError: ROS 2 has no such names
    """
    if not re.fullmatch(NAME_FORM, text):
        raise argparse.ArgumentTypeError(
            f'expected a name such as /line_1/bt_orchestrator, found {text!r}'
        )
    return text


def port(text: str) -> int:
    """Read the number of a port.

    :raises ArgumentTypeError: it is none
    """
    if not (text.isascii() and text.isdecimal() and len(text) < 6 and int(text) <= 65535):
        raise argparse.ArgumentTypeError(f'expected a port from 0 to 65535, found {text!r}')
    return int(text)


def _finite(text: str) -> float:
    """Return a number; -1 for what is none."""
    try:
        number = float(text)
    except ValueError:
        return -1.0
    return number if math.isfinite(number) else -1.0
