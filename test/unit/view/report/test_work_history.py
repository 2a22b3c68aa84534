"""The last work of a section or a component, of a line whose clock somebody sets."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest
from fakes.journal_reading import journal_reading
from fakes.profiles import examples
from fakes.stepped import Steps, drawn_steps, stepped
from fakes.told_item import ToldItem
from hypothesis import given

from bt_orchestrator.model import events as e
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.view.report.work_history import WorkFold


@pytest.fixture(scope='module')
def run(tmp_path_factory: pytest.TempPathFactory) -> list[e.Event]:
    path: Path = ToldItem().write(tmp_path_factory.mktemp('told') / 'cell.sqlite3')
    with journal_reading(path) as reading:
        return list(reading.events(Wanted()))


def measured(
    events: Sequence[e.Event], section: int | None, component: str | None
) -> dict[str, float | None]:
    fold = WorkFold(section, component)
    for event in events:
        fold.follow(event)
    fold.until(events[-1].time)
    return {
        **fold.time_in,
        **{f'{name} {n}': s for name, times in fold.times.items() for n, s in enumerate(times)},
        **{f'cycle {n}': cycle.seconds for n, cycle in enumerate(fold.cycles)},
    }


@pytest.mark.parametrize(
    ('section', 'component'), [(1, None), (2, None), (3, None), (None, 'a2'), (None, 'arm')]
)
@examples(10, 300)
@given(drawn_steps())
def test_a_clock_that_is_set_changes_no_duration(
    run: list[e.Event], section: int | None, component: str | None, steps: Steps
) -> None:
    set_back = measured(stepped(run, steps), section, component)
    assert set_back == pytest.approx(measured(run, section, component), abs=1e-4)
