"""What several integration tests begin with."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
import rclpy
from cell_fixtures import loaded
from rclpy.context import Context
from thread_servers import ThreadServers

__all__ = ['context', 'loaded', 'servers']


@pytest.fixture
def context() -> Iterator[Context]:
    """Give a ROS context of its own, which a test may shut down itself."""
    context = Context()
    rclpy.init(context=context)
    yield context
    context.try_shutdown()


@pytest.fixture
def servers() -> Iterator[ThreadServers]:
    """Give action servers that run in a thread of this process."""
    servers = ThreadServers()
    yield servers
    servers.close()
