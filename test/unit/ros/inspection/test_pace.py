"""When watchers are shown something again."""

from __future__ import annotations

import pytest

from bt_orchestrator.ros.inspection.server import AFTER_ERROR_S, SHARE, Pace


class Processor:
    """What a thread has used of it, in seconds."""

    used_s = 5.0

    def work(self, seconds: float) -> None:
        self.used_s += seconds


def after_turn(worked_s: float) -> Pace:
    """Return the pace after a turn at 100 s that used so much of the processor."""
    processor = Processor()
    pace = Pace(lambda: processor.used_s)
    assert pace.may_begin(100.0)
    with pace.turn(100.0):
        processor.work(worked_s)
    return pace


def test_long_turn_is_followed_by_proportional_pause() -> None:
    pace = after_turn(worked_s=0.2)
    assert not pace.may_begin(100.0 + 0.2 / SHARE - 0.01)
    assert pace.may_begin(100.0 + 0.2 / SHARE)


def test_waiting_for_processor_does_not_lengthen_pause() -> None:
    assert after_turn(worked_s=0.001).may_begin(100.5), 'it has taken half a second by the clock'


def test_failed_turn_is_retried_a_moment_later() -> None:
    pace = Pace(lambda: 5.0)
    with pytest.raises(ZeroDivisionError), pace.turn(100.0):
        raise ZeroDivisionError
    assert not pace.may_begin(100.0 + AFTER_ERROR_S - 0.01)
    assert pace.may_begin(100.0 + AFTER_ERROR_S)
