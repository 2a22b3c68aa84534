"""One server for all tests of a file: loading what every server has takes seconds."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from fakes.guarded import Served


@pytest.fixture(scope='module')
def secure(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """A server as it is started for a plant."""
    made = Served(tmp_path_factory.mktemp('secure'), insecure=False)
    yield made
    made.close()


@pytest.fixture(scope='module')
def insecure(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """A server that lets in who does not encrypt."""
    made = Served(tmp_path_factory.mktemp('insecure'), insecure=True)
    yield made
    made.close()
