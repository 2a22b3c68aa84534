"""One of each for all tests: loading what every server has takes seconds."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing

import pytest
from fakes.bare_space import BareSpace
from fakes.guarded import Served
from opcua_stand import opcua_stand
from web.stand_cell import StandCell

from bt_orchestrator.extensions.opcua.server import nodesets
from bt_orchestrator.extensions.opcua.server.job_control.structures import Structures


@pytest.fixture(scope='session', autouse=True)
def with_all_memory() -> Iterator[None]:
    """Give no memory back after a build: it would look through all that a run of tests holds."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr('bt_orchestrator.extensions.opcua.server.server.give_back', lambda: None)
        yield


@pytest.fixture(scope='session')
def secure(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """A server as it is started for a plant."""
    with closing(Served(tmp_path_factory.mktemp('secure'), insecure=False)) as made:
        yield made


@pytest.fixture(scope='session')
def insecure(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """A server that lets in who does not encrypt."""
    with closing(Served(tmp_path_factory.mktemp('insecure'), insecure=True)) as made:
        yield made


@pytest.fixture(scope='session')
def in_space() -> Iterator[BareSpace]:
    """Does something in an address space without a cell."""
    with closing(BareSpace()) as made:
        yield made


@pytest.fixture(scope='session')
def structures(in_space: BareSpace) -> Structures:
    return Structures(in_space.ns[nodesets.JOB_CONTROL.uri])


@pytest.fixture(scope='package')
def line(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[StandCell, str]]:
    """A line, and its address, for tests that leave it empty, with nothing in its queue."""
    with opcua_stand(tmp_path_factory.mktemp('stand')) as (cell, server):
        yield cell, server.address


@pytest.fixture
def script(line: tuple[StandCell, str]) -> str:
    """Name a script of the line."""
    return line[0].script


@pytest.fixture
def url(line: tuple[StandCell, str]) -> str:
    """Say where the line is served."""
    return line[1]
