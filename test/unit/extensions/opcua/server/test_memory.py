"""Whether what was built is looked through for garbage."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Iterator
from contextlib import suppress

import pytest

from bt_orchestrator.extensions.opcua.server.library import building, give_back


@pytest.fixture(autouse=True)
def as_before() -> Iterator[None]:
    yield
    gc.enable()
    gc.unfreeze()


def test_collector_is_off_only_during_build() -> None:
    with suppress(OSError), building():
        with building():
            assert not gc.isenabled()
        assert not gc.isenabled()
        raise OSError('it failed')
    assert gc.isenabled()


def test_first_finished_build_leaves_collector_off() -> None:
    first, second = building(), building()
    first.__enter__()
    second.__enter__()
    second.__exit__(None, None, None)
    assert not gc.isenabled()
    first.__exit__(None, None, None)
    assert gc.isenabled()


def test_built_objects_are_collected_at_next_build() -> None:
    class Built:
        """It refers to itself, so that only the collector can end it."""

        def __init__(self) -> None:
            self.itself = self

    def build() -> weakref.ref[Built]:
        built = Built()
        give_back()
        return weakref.ref(built)

    built = build()
    gc.collect()
    assert built() is not None
    give_back()
    assert built() is None
