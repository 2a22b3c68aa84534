"""A status in PackML's words."""

from __future__ import annotations

from fakes.statuses import NOW_S, hold, status

from bt_orchestrator.extensions.opcua.mes.packml import Stop, packml_values
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.stop_reason import StopReason


def test_state_and_times_are_numbers_and_whole_seconds() -> None:
    times = {PackmlState.EXECUTE: 112.9, PackmlState.HELD: 40.0}
    values = packml_values(status(state_times=times))
    assert values.state == 6
    assert values.in_state_s == {6: 12}
    assert values.total_s == {6: 112, 11: 40}


def test_set_back_clock_makes_no_negative_time() -> None:
    values = packml_values(status(state_since=NOW_S + 5))
    assert values.in_state_s == {6: 0}


def test_only_acting_states_are_changing() -> None:
    changing = {
        state.value for state in PackmlState if packml_values(status(state=state)).is_changing
    }
    assert changing == {
        'Resetting', 'Starting', 'Completing', 'Holding', 'Unholding', 'Suspending',
        'Unsuspending', 'Stopping', 'Aborting', 'Clearing',
    }  # fmt: skip


def test_a_starved_line_and_a_blocked_one() -> None:
    starved = packml_values(status(stop_reason=StopReason.STARVED))
    blocked = packml_values(status(stop_reason=StopReason.BLOCKED))
    assert (starved.is_starved, starved.is_blocked) == (True, False)
    assert (blocked.is_starved, blocked.is_blocked) == (False, True)


def test_stop_reason_names_deciding_hold() -> None:
    held = hold('3', reason='timeout', since=950.0)
    about = {'stop_reason': StopReason.OWN_FAULT, 'stop_message': 'hold 3 (work: timeout)'}
    stop = packml_values(status(holds=[held], **about)).stop
    assert (stop.reason.number, stop.hold, stop.since) == (205, 3, 950.0)
    assert stop.message == 'hold 3 (work: timeout)'


def test_a_line_that_works_has_no_stop_reason() -> None:
    assert packml_values(status()).stop == Stop()


def test_a_journal_that_cannot_be_written_comes_first() -> None:
    held = hold('3', reason='timeout', since=950.0)
    about = {'stop_reason': StopReason.OWN_FAULT, 'journal_failure': 'the disk is full'}
    stop = packml_values(status(holds=[held], **about)).stop
    assert (stop.reason.number, stop.hold, stop.message) == (600, 0, 'the disk is full')
