"""Long tests begin first: no worker is left with one when the others have nothing more to do."""

from __future__ import annotations

import os
from collections.abc import Sequence

import pytest


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Deal them out, where tests are shared out."""
    workers = int(os.environ.get('PYTEST_XDIST_WORKER_COUNT', '1'))
    if workers > 1:
        is_long = [item.get_closest_marker('long') is not None for item in items]
        items[:] = [items[place] for place in dealt(is_long, workers)]


def dealt(is_long: Sequence[bool], workers: int) -> list[int]:
    """Return the places of all tests in their new order.

    Each worker begins with its share, which is a piece of the list, and takes of another's later
    (`--dist worksteal`). So each share begins with some of the long ones.
    """
    long, short = ([n for n, flag in enumerate(is_long) if flag is kind] for kind in (True, False))
    places: list[int] = []
    for worker in range(workers):
        share = (len(is_long) - len(places)) // (workers - worker)
        first = long[worker::workers][:share]
        number = share - len(first)
        places += [*first, *short[:number]]
        short = short[number:]
    return [*places, *(n for n in long if n not in places), *short]
