"""The account of one shift that was written and worked out by hand.

Early shift, 06:00 to 14:00 with a break from 09:00 to 09:30: 27,000 s are planned. The line makes
an item every 30 s at its pace. What is lost, second by second:

    no order     06:00 to 06:10                                            600
    operator     06:10 to 06:15 not started, 08:00 to 08:10 paused,
                 12:10 to 12:15 stopped                                  1,200
    setup        06:15 to 06:20                                            300
    own fault    07:00 to 07:20 hold 1, 13:10 to 13:12 hold 3            1,320
    rework       07:20 to 07:25                                            300
    waiting      1 s before it was starved, 1 s before it was blocked        2
    starved      10:00:01 to 10:10:01                                      600
    blocked      11:00:01 to 11:05:01                                      300
    emergency    12:00 to 12:10                                            600
    no node      13:00 to 13:10, killed                                    600

Planned busy 26,400 s; without 4,922 s of availability the actual production time is 21,478 s. 518
items were made, 15,540 s at the pace: 5,638 s were slow cycles. 18 of them were not good: 540 s.
OEE = 500 x 30 s of 26,400 s.
"""

from __future__ import annotations

import json
from datetime import date
from fractions import Fraction

import pytest
from fakes.day import at
from fakes.hand_made_shift import LINE, SHIFTS, the_day

from bt_orchestrator.script.shifts.shifts_file import parse_shifts
from bt_orchestrator.view.report.account.account import Account, account
from bt_orchestrator.view.report.account.calendar import shift_on, turns_on, zone_of
from bt_orchestrator.view.report.account.causes.flaws import flaw_words
from bt_orchestrator.view.report.account.losses import Loss, Part
from bt_orchestrator.view.report.account.plain import account_plain
from bt_orchestrator.view.report.account.stops import FailingTask, Repairs, Stop
from bt_orchestrator.view.report.account.text import account_text
from bt_orchestrator.view.report.reading import Reading

S = 1_000_000


@pytest.fixture(scope='module')
def made() -> Account:
    shifts = parse_shifts(SHIFTS, 'shifts.yaml')
    zone = zone_of(shifts)
    monday = shift_on(shifts.shifts['early'], date(2026, 5, 18), zone, at('23:00'))
    return account(Reading(the_day().records()), monday, LINE.cell)


def test_waterfall_matches_hand_made_figures(made: Account) -> None:
    bars = [(bar.title, float(bar.us) / S) for bar in made.figures.waterfall()]
    assert bars == [
        ('planned time', 27000.0),
        ('no order', 600.0),
        ('planned busy time', 26400.0),
        ('node not running', 600.0),
        ('own fault', 1320.0),
        ('operator', 1200.0),
        ('starved', 600.0),
        ('blocked', 300.0),
        ('emergency', 600.0),
        ('setup', 300.0),
        ('waiting', 2.0),
        ('actual production time', 21478.0),
        ('rework', 300.0),
        ('slow cycles', 5638.0),
        ('net production time', 15540.0),
        ('rejects', 540.0),
        ('value adding time', 15000.0),
    ]


def test_oee_is_the_product_of_its_parts(made: Account) -> None:
    shown = made.figures
    assert shown.availability == Fraction(21478, 26400)
    assert shown.performance == Fraction(15540, 21478)
    assert shown.quality == Fraction(500, 518)
    assert shown.oee == Fraction(15000, 26400)
    assert shown.oee == shown.availability * shown.performance * shown.quality


def test_quantities_and_rate(made: Account) -> None:
    (job,) = made.figures.times.made
    counts = (job.good, job.nonconforming, job.rejected, job.by_hand, job.outside)
    assert counts == (500, 6, 10, 2, 20)
    assert made.figures.per_item_us == Fraction(21478 * S, 518)
    assert made.figures.pace_us == 30 * S


def test_each_loss_goes_down_to_its_holds(made: Account) -> None:
    holds = [
        (hold.hold, hold.loss, hold.lost_us // S, hold.who, hold.answer, hold.reason)
        for hold in made.figures.times.holds
    ]
    assert holds == [
        ('1', Loss.OWN_FAULT, 1200, 'ann', 'retry', 'cleared the jam'),
        ('2', Loss.OPERATOR, 600, 'ann', 'resume', 'back'),
        ('9', None, 0, 'ann', 'clear', ''),
        ('3', Loss.OWN_FAULT, 120, 'ann', 'resume', 'looked at it'),
    ]
    assert made.figures.times.holds[0].words == (
        'section 2, work (TASK_A) of J/1 at a2 (/a2/do), attempt 1 of 1: aborted (jam)'
    )


def test_the_stops_by_cause(made: Account) -> None:
    assert made.figures.times.stops[:4] == (
        Stop(Loss.OWN_FAULT, 'TASK_A aborted', 'a2', 1, 1200 * S, Part.FAULT),
        Stop(Loss.EMERGENCY, 'abort', '', 1, 600 * S),
        Stop(Loss.NO_NODE, '', '', 1, 600 * S),
        Stop(Loss.NO_ORDER, '', '', 1, 600 * S),
    )
    waits = [stop for stop in made.figures.times.stops if stop.loss is Loss.WAITING]
    assert waits == [
        Stop(Loss.WAITING, 'a1 not ready', 'a1', 1, S),
        Stop(Loss.WAITING, 'a3 not ready', 'a3', 1, S),
    ]


def test_own_fault_and_operator_are_parted(made: Account) -> None:
    shown = made.figures
    assert [(part.value, (shown.part_us(part) or 0) // S) for part in Part if part.value] == [
        ('fault', 1200),
        ('answer', 120),
        ('paused', 600),
        ('not_started', 600),
        ('manual', 0),
    ]
    assert shown.micro_stops() == (1, 120 * S)
    assert shown.breakdowns() == (1, 1200 * S)
    assert shown.breakdowns('a2') == (1, 1200 * S)
    assert shown.micro_stops('a2') == (0, 0)


def test_shift_file_sets_micro_stop_threshold() -> None:
    shifts = parse_shifts(f'{SHIFTS}micro_stop: 100\n', 'shifts.yaml')
    (turn,) = turns_on(shifts, [date(2026, 5, 18)], zone_of(shifts))
    shown = account(Reading(the_day().records()), turn.period, LINE.cell).figures
    assert shown.breakdowns() == (2, 1320 * S)
    assert shown.micro_stops() == (0, 0)


def test_failures_and_the_time_to_repair(made: Account) -> None:
    """What `abort` cancelled is no failure of the component."""
    times = made.figures.times
    first, last = times.failing
    assert first == FailingTask('a2', 'TASK_A', 'in_doubt', 1, 3299 * S)
    assert last == FailingTask('a2', 'TASK_A', 'aborted', 1, 2400 * S)
    (repairs,) = times.repairs
    assert repairs == Repairs('a2', 1, 1200 * S, 1200 * S)
    assert made.figures.mttr_us(repairs) == 1200 * S
    # its goals were in flight from 06:20 to 07:00, 07:20 to 10:00, 10:10:01 to 11:00, 11:05:01 to
    # 12:00 and 12:15 to 14:00, without the break and the time without a node
    assert made.figures.mtbf_us(repairs) == (2400 + 7800 + 2999 + 3299 + 5700) * S


def test_the_causes_of_what_is_not_good(made: Account) -> None:
    causes = [
        (flaw_words(row.of), row.of.effect.value, row.times) for row in made.figures.times.flaws
    ]
    assert causes == [
        ('by the script', 'rejected', 10),
        ('work, answer mark_done', 'nonconforming', 6),
        ('remove-item', 'by_hand', 2),
        ('work at a2 aborted, answer retry', 'attempt', 1),
    ]
    assert made.figures.first_pass_yield == Fraction(500, 518)


def test_text_and_json_say_the_same(made: Account) -> None:
    text = '\n'.join(account_text(made))
    assert 'OEE  56.8 % = availability 81.4 % x performance 72.4 % x quality 96.5 %' in text
    assert 'rate 41.5 s an item, 86.8 an hour of production; the pace is 30.0 s an item' in text
    plain = json.loads(json.dumps(account_plain(made)))
    assert plain['oee']['oee'] == 0.568182
    assert plain['losses']['own_fault'] == 1320.0
    assert sum(plain['losses'].values()) == 27000.0 - 15000.0
    assert plain['made_from']['history'] == 'day'
