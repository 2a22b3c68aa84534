"""What all tests of doors do: ask, let something happen, wait for it."""

from __future__ import annotations

import itertools
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from contract.link_bench import LinkBench
from patience import PATIENCE_S
from ros_domain import kept_domain

from bt_orchestrator.model.by import By, Known, Role
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.jobs.order import WorkOrder
from bt_orchestrator.model.requests import ask
from bt_orchestrator.ports import CellLink

ANN = By('Ann', 'contract', 'because', Role.ENGINEER, Known.LOCAL_USER)


numbers = itertools.count(1)
"""For names that nothing else has."""


def new_id() -> str:
    """Return the id of an order that no other one has."""
    return f'O-{next(numbers)}'


def asked_of(link: CellLink, name: str, **given: Any) -> Answer:
    return link.ask(ask(name, ANN, **given))


def add(link: CellLink, *names: str, script: str = 'small', held: bool = True) -> Answer:
    orders = [WorkOrder(script, name, 1) for name in names]
    return asked_of(link, 'queue.add', orders=orders, held=held)


def turn_until(link: CellLink, condition: Callable[[], Any], what: str) -> None:
    """Handle what comes until a condition holds; fails if it does not in time."""
    deadline = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < deadline, f'no {what}'
        link.turn(0.1)


def happen(link: CellLink, count: int = 1) -> int:
    """Let some events happen; returns the number of the last one so far."""
    for _ in range(count):
        assert add(link, new_id()).accepted
    return link.events_after(link.status().seq - 1).last_seq


class DoorTests(ABC):
    """One bench serves all tests, each with doors of its own."""

    @staticmethod
    @abstractmethod
    def make_bench(folder: Path) -> LinkBench:
        """Return a bench whose node runs."""

    @pytest.fixture(scope='class')
    @classmethod
    def shared_bench(cls, tmp_path_factory: pytest.TempPathFactory) -> Iterator[LinkBench]:
        with kept_domain():
            bench = cls.make_bench(tmp_path_factory.mktemp('link'))
            yield bench
            bench.close()

    @pytest.fixture
    def bench(self, shared_bench: LinkBench) -> LinkBench:
        """Give the bench with its node at work, whatever a test before has done."""
        if not shared_bench.is_on:
            shared_bench.start(shared_bench.journal)
        return shared_bench

    @pytest.fixture
    def link(self, bench: LinkBench) -> Iterator[CellLink]:
        link = bench.link()
        yield link
        link.close()
