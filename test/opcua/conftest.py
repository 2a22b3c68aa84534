"""Fixtures of the tests with OPC UA clients of another make."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from cell_fixtures import fast_discovery, start_cell
from opcua.driver import Driver

__all__ = ['fast_discovery', 'start_cell']

StartDriver = Callable[..., Driver]
"""Starts node-opcua; takes endpoint, namespace and a name."""


@pytest.fixture
def start_driver(tmp_path: Path) -> Iterator[StartDriver]:
    """Give a function that starts node-opcua."""
    with ExitStack() as stack:

        def start(endpoint: str, namespace: str, name: str = 'foreign') -> Driver:
            driver = Driver(tmp_path, endpoint, namespace, name)
            stack.callback(driver.close)
            return driver

        yield start
