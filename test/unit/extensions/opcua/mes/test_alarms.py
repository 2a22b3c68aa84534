"""What waits for people, as conditions."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from fakes.statuses import component, hold, status

from bt_orchestrator.extensions.opcua.mes.alarms import alarms_of, event_id
from bt_orchestrator.model.stop_reason import StopReason, Wish

HOLD = hold('3', reason='timeout', message='too slow', since=950.0)


def keys(**about: Any) -> list[str]:
    return list(alarms_of(status(**about)))


def test_hold_condition_has_message_source_and_answers() -> None:
    alarm = alarms_of(status(holds=[HOLD]))['Hold-3']
    assert alarm.message == (
        'section 2, work (TASK_A) of WO-1/1 at arm (/arm/task), attempt 1 of 2: timeout (too slow)'
    )
    assert alarm.text.endswith('; answers: retry, skip')
    assert (alarm.source, alarm.severity, alarm.hold) == ('Components/arm', 600, '3')
    assert alarm.since == 950.0


def test_hold_without_component_names_section_or_cell() -> None:
    of_item = replace(HOLD, id='4', component='', task=None, section=3, reason='overrun')
    pause = hold('5', section=None, item=None, task=None, component='', reason='paused')
    alarms = alarms_of(status(holds=[of_item, pause]))
    assert [alarm.source for alarm in alarms.values()] == ['Sections/3', '']


def test_what_goes_on_by_itself_is_no_condition() -> None:
    for reason in (StopReason.STARVED, StopReason.BLOCKED, StopReason.OPERATOR):
        assert keys(stop_reason=reason) == []


def test_abort_journal_failure_and_contest_are_conditions() -> None:
    rival = replace(component('worker'), contested='two servers')
    assert keys(
        stop_reason=StopReason.EMERGENCY, journal_failure='the disk is full', components=[rival]
    ) == ['Journal', 'Emergency', 'Contest-worker']


def test_an_emergency_began_when_somebody_aborted() -> None:
    by = Wish('abort', 'Ann', 'smoke', 990.0, 'page login')
    alarm = alarms_of(status(stop_reason=StopReason.EMERGENCY, wish=by))['Emergency']
    assert alarm.since == 990.0


def test_an_event_id_depends_on_the_facts_alone() -> None:
    alarm = alarms_of(status(holds=[HOLD]))['Hold-3']
    again = alarms_of(status(holds=[replace(HOLD)]))['Hold-3']
    fewer = alarms_of(status(holds=[replace(HOLD, answers=('retry',))]))['Hold-3']
    assert len(event_id('a', alarm)) == 16
    assert event_id('a', alarm) == event_id('a', again)
    others = [
        event_id('b', alarm), event_id('a', fewer), event_id('a', alarm, 'acknowledged'),
    ]  # fmt: skip
    assert len({event_id('a', alarm), *others}) == 4
