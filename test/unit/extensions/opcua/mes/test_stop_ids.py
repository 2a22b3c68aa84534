"""Numbers of stop reasons never change."""

from __future__ import annotations

from typing import Any

import pytest
from fakes.statuses import hold, status

from bt_orchestrator.extensions.opcua.mes.alarms import NONE, STOP_IDS, id_of_hold, id_of_stop
from bt_orchestrator.model import stop_reason
from bt_orchestrator.model.goal import Reason
from bt_orchestrator.model.stop_reason import StopReason
from bt_orchestrator.model.words import OVERRUN

KEPT = {
    0: '', 100: 'stopped', 101: 'paused', 200: 'own_fault', 201: 'server_unavailable',
    202: 'goal_rejected', 203: 'aborted', 204: 'canceled', 205: 'timeout',
    206: 'task_result_false', 207: 'missing_result', 208: 'server_lost', 209: 'in_doubt',
    210: 'result_refused', 211: 'slot_occupied', 212: 'overrun',
    213: 'duplicate_serial',
    214: 'setup_missing', 221: 'restarted',
    222: 'restored', 223: 'missing',
    224: 'twin', 225: 'unknown_goal', 226: 'too_many_rejects',
    227: 'safety',
    300: 'starved', 400: 'blocked', 500: 'emergency',
    600: 'journal', 610: 'contested',
}  # fmt: skip
"""Sites keep tables of them: add numbers here, never change one."""


def test_the_numbers_are_those_that_sites_know() -> None:
    assert {stop_id.number: stop_id.word for stop_id in STOP_IDS} == KEPT


@pytest.mark.parametrize(
    'reason',
    [
        *(member.value for member in Reason),
        *sorted(stop_reason.NAMED),
        stop_reason.PAUSED,
        'slot_occupied',
        OVERRUN,
    ],
)
def test_hold_reasons_have_number_and_severity(reason: str) -> None:
    stop_id = id_of_hold(hold(reason=reason))
    assert stop_id.word == reason
    assert 1 <= stop_id.severity <= 1000


def test_an_unknown_reason_is_another_fault() -> None:
    assert id_of_hold(hold(reason='flooded')).number == 200


@pytest.mark.parametrize(
    ('about', 'number'),
    [
        ({}, 0),
        ({'stop_reason': StopReason.OPERATOR}, 100),
        ({'stop_reason': StopReason.OPERATOR, 'holds': [hold(reason='paused', owner='Ann')]}, 101),
        ({'stop_reason': StopReason.OWN_FAULT, 'holds': [hold(reason='timeout'), hold()]}, 205),
        ({'stop_reason': StopReason.STARVED}, 300),
        ({'stop_reason': StopReason.BLOCKED}, 400),
        ({'stop_reason': StopReason.EMERGENCY, 'holds': [hold(reason='in_doubt')]}, 500),
        ({'stop_reason': StopReason.OWN_FAULT, 'journal_failure': 'the disk is full'}, 600),
    ],
)
def test_what_stops_the_line_has_a_number(about: dict[str, Any], number: int) -> None:
    stop_id = id_of_stop(status(**about))
    assert stop_id.number == number
    assert stop_id.category == number // 100


def test_none_is_no_reason() -> None:
    assert id_of_stop(status()) is NONE
