"""Fixtures of the tests with OPC UA clients of another make."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from cell_fixtures import fast_discovery, loaded, start_cell
from cell_processes import StartCell
from opcua.driver import Driver
from opcua.line import Line

__all__ = ['fast_discovery', 'loaded', 'start_cell']

StartDriver = Callable[..., Driver]
"""Starts node-opcua; takes endpoint, namespace and a name."""

Tell = Callable[[str], None]
"""Adds a line to the report of a test, which `-rP` shows."""


@pytest.fixture
def tell(request: pytest.FixtureRequest) -> Tell:
    """Give a function that tells what was measured."""
    return lambda text: request.node.add_report_section('call', 'measured', text)


@pytest.fixture
def start_driver(tmp_path: Path) -> Iterator[StartDriver]:
    """Give a function that starts node-opcua."""
    with ExitStack() as stack:

        def start(endpoint: str, namespace: str, name: str = 'foreign') -> Driver:
            driver = Driver(tmp_path, endpoint, namespace, name)
            stack.callback(driver.close)
            return driver

        yield start


StartLine = Callable[..., Line]
"""Starts a line and waits until its server serves; takes options of `CellProcesses`."""


@pytest.fixture
def start_line(tmp_path: Path, start_cell: StartCell) -> Iterator[StartLine]:
    """Give a function that starts a line."""
    with ExitStack() as stack:

        def start(**cell: Any) -> Line:
            line = Line(tmp_path, start_cell, **cell)
            stack.callback(line.close)
            line.server.wait_ready()
            return line

        yield start
