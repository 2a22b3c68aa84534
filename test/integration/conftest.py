"""What several integration tests begin with."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from thread_servers import ThreadServers


@pytest.fixture
def servers() -> Iterator[ThreadServers]:
    """Give action servers that run in a thread of this process."""
    servers = ThreadServers()
    yield servers
    servers.close()
