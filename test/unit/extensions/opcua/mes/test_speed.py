"""The speed of the line, from the moves of its belt."""

from __future__ import annotations

import pytest

from bt_orchestrator.extensions.opcua.mes.packml import Speedometer
from bt_orchestrator.model.events import BeltIndexed, CellStateChanged, ClockStepped
from bt_orchestrator.model.packml import PackmlState

EXECUTE = PackmlState.EXECUTE


def executing(since: float, *moves: float) -> Speedometer:
    speed = Speedometer()
    speed.hear(CellStateChanged(state='Execute', previous='Starting', time=since))
    for beat, time in enumerate(moves):
        speed.hear(BeltIndexed(beat=beat, time=time))
    return speed


def test_ten_second_moves_give_six_per_minute() -> None:
    speed = executing(0.0, 10.0, 20.0, 30.0)
    assert speed.a_minute(EXECUTE, 31.0) == pytest.approx(6.0)


def test_only_the_last_ten_moves_count() -> None:
    slow = [60.0 * n for n in range(1, 6)]
    quick = [300.0 + 6.0 * n for n in range(1, 11)]
    assert executing(0.0, *slow, *quick).a_minute(EXECUTE, 361.0) == pytest.approx(10.0)


def test_an_overdue_move_makes_it_slower() -> None:
    speed = executing(0.0, 10.0, 20.0)
    assert speed.a_minute(EXECUTE, 30.0) == pytest.approx(6.0)
    assert speed.a_minute(EXECUTE, 90.0) == pytest.approx(2.0)


def test_before_the_first_move_it_is_not_known() -> None:
    assert executing(0.0).a_minute(EXECUTE, 5.0) is None
    assert Speedometer().a_minute(EXECUTE, 5.0) is None


def test_late_listener_waits_for_second_move() -> None:
    speed = Speedometer()
    speed.hear(BeltIndexed(beat=7, time=100.0))
    assert speed.a_minute(EXECUTE, 101.0) is None
    speed.hear(BeltIndexed(beat=8, time=110.0))
    assert speed.a_minute(EXECUTE, 111.0) == pytest.approx(6.0)


def test_standstill_has_zero_speed_and_is_excluded() -> None:
    speed = executing(0.0, 10.0, 20.0)
    speed.hear(CellStateChanged(state='Holding', previous='Execute', time=25.0))
    assert speed.a_minute(PackmlState.HELD, 3_000.0) == 0.0
    speed.hear(CellStateChanged(state='Execute', previous='Unholding', time=3_000.0))
    speed.hear(BeltIndexed(beat=4, time=3_010.0))
    assert speed.a_minute(EXECUTE, 3_011.0) == pytest.approx(6.0)


def test_set_back_clock_gives_no_speed() -> None:
    assert executing(100.0, 50.0).a_minute(EXECUTE, 51.0) is None


@pytest.mark.parametrize('step_s', [3600.0, -3600.0, -50.0])
def test_a_clock_that_is_set_changes_no_speed(step_s: float) -> None:
    speed = executing(0.0, 10.0, 20.0)
    speed.hear(ClockStepped(seconds=step_s, time=25.0 + step_s))
    assert speed.a_minute(EXECUTE, 26.0 + step_s) == pytest.approx(6.0)
    speed.hear(BeltIndexed(beat=3, time=30.0 + step_s))
    assert speed.a_minute(EXECUTE, 31.0 + step_s) == pytest.approx(6.0)
