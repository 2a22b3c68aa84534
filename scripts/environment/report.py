"""What the user gets to see."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager


class Failure(Exception):
    """Something the user has to act on; the text says what."""


def say(text: str) -> None:
    """Progress goes to stderr: scripts that print results run the bootstrap first."""
    print(f'bootstrap: {text}', file=sys.stderr, flush=True)


@contextmanager
def timed(text: str) -> Iterator[None]:
    print(f'bootstrap: {text} ...', file=sys.stderr, end=' ', flush=True)
    started = time.monotonic()
    try:
        yield
    except BaseException:
        print('failed', file=sys.stderr, flush=True)
        raise
    print(f'{time.monotonic() - started:.0f} s', file=sys.stderr, flush=True)
