"""A virtual run that would take the memory of the machine ends with a sentence."""

from __future__ import annotations

import itertools
import json
from pathlib import Path

import pytest
from fakes.action_types import FakeActionTypes
from fakes.shipped import REFERENCE_CELL, TREES

from bt_orchestrator.cli.main import main
from bt_orchestrator.cli.simulating.cost_watch import CostWatch, TooCostly
from bt_orchestrator.model.events import BeltIndexed


def after_beats(watch: CostWatch, beats: int) -> None:
    for number in range(beats):
        watch.publish([BeltIndexed(beat=number)])
        watch.look()


def test_a_run_that_fits_goes_on() -> None:
    used = (1e9 + 1e4 * number for number in itertools.count())
    after_beats(CostWatch(100_000, 1e9, lambda: next(used)), 100_000)


def test_run_that_cannot_fit_ends_early() -> None:
    used = (1e9 + 1e7 * number for number in itertools.count())
    watch = CostWatch(2**31 - 1, 1e9, lambda: next(used))
    with pytest.raises(
        TooCostly, match=r'2147483647 items would take about 21,474.8 GB of memory'
    ):
        after_beats(watch, 1_001)


def test_excessive_memory_use_ends_any_run() -> None:
    used = (1e9 + 4e8 * number for number in itertools.count())
    with pytest.raises(TooCostly, match='ended after 3000 beats'):
        after_beats(CostWatch(1, 1e9, lambda: next(used)), 3_001)


@pytest.mark.timeout(120)
def test_simulate_refuses_order_of_two_billion_items(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr('bt_orchestrator.cli.bootstrap.installed_types', FakeActionTypes)
    order = tmp_path / 'order.yaml'
    order.write_text(json.dumps({'script': 'inspect_and_assemble', 'quantity': 2**31 - 1}))
    cell = tmp_path / 'cell.yaml'
    cell.write_text(f'{REFERENCE_CELL.read_text()}\nmost_items: 2147483647\n')
    words = ['simulate', str(order), '--cell', str(cell), '--trees', str(TREES)]
    assert main(words) == 1
    assert '2147483647 items would take about' in capsys.readouterr().err
