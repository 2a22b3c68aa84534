"""Moments on the command line."""

from __future__ import annotations

import argparse
from datetime import datetime


def moment(text: str) -> float:
    """Return seconds since the epoch of a time as people write it.

    :raises ArgumentTypeError: it is no time
    """
    try:
        return datetime.fromisoformat(text).timestamp()
    except ValueError as error:
        raise argparse.ArgumentTypeError(
            f'{text!r} is no time; write 2026-05-17, or 2026-05-17T14:30, with +02:00 or without'
        ) from error
