"""The account of drawn runs: it closes, and a second opinion comes to the same."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from datetime import date, datetime
from fractions import Fraction
from typing import Any
from zoneinfo import ZoneInfo

import pytest
from fakes.drawn.lines import lines
from fakes.drawn.plan import Plan
from fakes.line import Line
from fakes.naive_account import NaiveAccount, naive_account, naive_stops
from fakes.plan_operator import operate
from fakes.plan_runs import ProductBench
from fakes.profiles import examples
from fakes.stepped import Steps, drawn_steps, nameless, stepped
from fakes.virtual_run import VirtualRun
from hypothesis import given
from hypothesis import strategies as st

from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.codec import from_record, to_plain, to_record
from bt_orchestrator.model.proof.pace import pace
from bt_orchestrator.model.script import Script
from bt_orchestrator.script.shifts.shifts_file import parse_shifts
from bt_orchestrator.view.report.account.calendar import shift_on, zone_of
from bt_orchestrator.view.report.account.figures import Figures, Paces, figures
from bt_orchestrator.view.report.account.fold import FOLLOWED, AccountFold, Times
from bt_orchestrator.view.report.account.losses import PARTS, Loss, Part, is_stop
from bt_orchestrator.view.report.account.period import Period
from bt_orchestrator.view.report.account.planned import Planned, us_of
from bt_orchestrator.view.report.account.steady_time import SteadyTime

pytestmark = pytest.mark.timeout(24 * 3600)

MARKS = st.lists(st.integers(0, 12), min_size=4, max_size=4, unique=True).map(sorted)
"""Where planned time begins, breaks, goes on and ends, in twelfths of the run."""

ALL = [0, 6, 6, 12]
"""Without a break, the whole run."""

RESTARTS = st.lists(st.tuples(st.integers(1, 99), st.booleans()), min_size=1, max_size=4)
"""Shares of the records, in hundredths, and whether the node tells its end."""

SECONDS = st.integers(0, 150).map(lambda tenths: tenths / 10)

TEXT = """
initialization: [{id: warm, @lamp}]
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: work, @a2, retries: 1}]
  3: [{id: pack, @a3, qty_change: -1, runs_for: all}]
"""


def accounts(
    records: list[dict[str, Any]], marks: list[int], cell: Cell, scripts: Mapping[str, Script]
) -> Figures:
    """Return the account of a run that both agree about.

    :param scripts: by job
    """
    end = max(round(records[-1]['time'] * 1_000_000), 12)
    first, off, on, last = (mark * end // 12 for mark in marks)
    planned = Planned.of([(first, off), (on, last)])
    records = [entry for entry in records if round(entry['time'] * 1_000_000) <= last]
    events = [from_record(entry) for entry in records if entry['event'] in FOLLOWED]
    quiet = {entry['time'] for entry in records} - {entry.time for entry in events}
    assert not quiet, 'the node was alive then, and no account would know it'
    fold, asked = AccountFold(planned, is_whole=True), AccountFold(planned, is_whole=True)
    for event in events:
        fold.follow(event)
        asked.follow(event)
        asked.until(us_of(event.time) + 3_000_000)
    assert asked.until(last) == fold.until(last) == fold.until(last)
    mine = figures(fold.until(last), Paces(cell), MICRO_STOP_US)

    def pace_us(job: str) -> Fraction:
        script_pace = pace(scripts[job.partition('-rest')[0]], cell)
        return Fraction(0) if script_pace is None else script_pace.limit.per_item_us

    naive = naive_account(records, planned.pieces, pace_us)
    booked = {loss.value: us for loss, us in mine.times.lost_us.items()}
    assert +Counter({**booked, 'production': mine.times.producing_us}) == +naive.times
    agrees(mine, naive)
    same_stops(mine.times, records, planned)
    same_classes(mine, records, planned)
    if mine.has_paces:  # one that gets stuck has none, and an item of it may be taken off by hand
        assert mine.oee == naive.oee
        closes(mine)
    return mine


def stepped_accounts(records: list[dict[str, Any]], marks: list[int], steps: Steps) -> None:
    """Compare the accounts of a run whose clock was set with that of the same run without."""
    run = [from_record(entry) for entry in records]
    events = stepped(run, steps)
    steady = SteadyTime()
    followed = [entry for entry in map(steady.of, events) if entry.event in FOLLOWED]
    begin, end = us_of(run[0].time), us_of(run[-1].time) + 1_000_000
    whole = Planned.of([(begin, end)])
    assert nameless(times_of(followed, whole, end)) == nameless(times_of(run, whole, end))

    low, high = steady.clock_span(begin, end)
    first, off, on, last = (low + mark * (high - low) // 12 for mark in marks)
    planned = Planned.of([(first, off), (on, last)])
    period = Period('drawn', first, last, planned).on(steady)
    shown = figures(times_of(followed, period.planned, period.end_us), Paces(None))
    known = [to_record(entry) for entry in events]
    naive = naive_account(known, planned.pieces, lambda _: Fraction(0))
    booked = {loss.value: us for loss, us in shown.times.lost_us.items()}
    assert +Counter({**booked, 'production': shown.times.producing_us}) == +naive.times
    agrees(shown, naive)


def agrees(shown: Figures, naive: NaiveAccount) -> None:
    """Assert that counts, causes, measured values and components are the same."""
    times, causes = shown.times, naive.causes
    assert (shown.good, shown.produced) == (naive.good, naive.produced)
    rows = {tuple(to_plain(row.of, whole=True).values()): row.times for row in times.flaws}
    assert rows == {
        (row.effect, row.decision, row.product, row.task, row.component, row.reason, row.bound): n
        for row, n in causes.rows.items()
    }
    assert shown.first_pass == sum(job['first_pass'] for job in causes.made.values())
    kinds = ('good', 'nonconforming', 'rejected', 'by_hand', 'first_pass', 'attempts', 'rounds')
    made = {
        row.job: {kind: getattr(row, kind) for kind in kinds}
        for row in times.made
        if any(getattr(row, kind) for kind in kinds)
    }
    assert made == {
        job: {kind: counts[kind] for kind in kinds} for job, counts in causes.made.items()
    }
    assert {
        (*(getattr(row.of, name) for name in BOUNDS),): (
            row.times,
            row.below,
            row.above,
            row.least,
            row.mean,
            row.greatest,
        )
        for row in times.measured
    } == causes.measured
    for part in ('fault', 'answer', 'paused', 'not_started'):
        assert shown.part_us(Part(part)) == naive.parts[part]
    parts = naive.components
    assert times.operated_us == +parts.operated
    repairs = {row.component: row for row in times.repairs}
    assert {name: row.failures for name, row in repairs.items()} == parts.failures
    assert +Counter({name: row.down_us for name, row in repairs.items()}) == +parts.down
    assert +Counter({name: row.repair_us for name, row in repairs.items()}) == +parts.repair
    for name, row in repairs.items():
        assert shown.mtbf_us(row) == Fraction(parts.operated[name], parts.failures[name])
        assert shown.mttr_us(row) == Fraction(parts.repair[name], parts.failures[name])


MICRO_STOP_US = 20_000_000
"""Runs are short: so long a fault is a breakdown here."""


def same_classes(shown: Figures, records: list[dict[str, Any]], planned: Planned) -> None:
    """Assert that both agree about every breakdown, and about all micro-stops together."""
    faults = [stop for stop in naive_stops(records, planned.pieces) if stop.loss == 'own_fault']
    long = [stop.us for stop in faults if stop.us >= MICRO_STOP_US]
    assert shown.breakdowns() == (len(long), sum(long))
    assert shown.micro_stops().us == sum(stop.us for stop in faults) - sum(long)
    assert shown.micro_stops().times == len(faults) - len(long)


BOUNDS = ('product', 'task', 'component', 'value', 'at_least', 'at_most')


def same_stops(times: Times, records: list[dict[str, Any]], planned: Planned) -> None:
    """Assert that both agree about every stop, its name, its hold and its length."""
    mine = [
        (span.seq, span.loss.value, span.hold, span.since_us, span.until_us, us)
        for span, us, _ in times.line_stops
    ]
    assert mine == [tuple(stop) for stop in naive_stops(records, planned.pieces)]
    assert len({stop[0] for stop in mine}) == len(mine)
    assert times.line_stops_us == sum(stop[-1] for stop in mine)
    stops_us = sum(us for loss, us in times.lost_us.items() if is_stop(loss))
    assert times.short_stops_us == stops_us - times.line_stops_us >= 0


def times_of(events: Sequence[e.Event], planned: Planned, end: int) -> Times:
    fold = AccountFold(planned, is_whole=True)
    for event in events:
        if event.event in FOLLOWED and us_of(event.time) <= end:
            fold.follow(event)
    return fold.until(end)


def closes(shown: Figures) -> None:
    """Assert that what is left and what is lost add up, exactly, at every step."""
    left, *bars = shown.waterfall()
    for bar in bars:
        assert bar.loss is not None or bar.us == left.us, bar
        left = bar if bar.loss is None else left._replace(us=left.us - bar.us)
    assert left.us == shown.value_us
    if shown.produced and shown.times.production_us:
        assert shown.availability is not None
        assert shown.performance is not None
        assert shown.quality is not None
        assert shown.oee == shown.availability * shown.performance * shown.quality
    times = shown.times
    held = sum(entry.lost_us for entry in times.holds) + sum(times.left_out_us.values())
    assert held <= sum(times.lost_us.get(loss, 0) for loss in (Loss.OWN_FAULT, Loss.OPERATOR))
    assert sum(entry.us for entry in times.stops) == sum(times.lost_us.values())
    parts = {part: shown.part_us(part) or 0 for part in PARTS}
    for loss in (Loss.OWN_FAULT, Loss.OPERATOR):
        of_loss = sum(us for part, us in parts.items() if PARTS[part].loss is loss)
        assert of_loss == times.lost_us.get(loss, 0)
    assert parts[Part.FAULT] == sum(entry.repair_us for entry in times.repairs)


def test_faults_pauses_and_starvation() -> None:
    seen: Counter[str] = Counter()

    @examples(12, 400)
    @given(
        unready=st.tuples(SECONDS, SECONDS),
        works=SECONDS,
        fault=st.sampled_from(['#2=abort #3=abort', '#1=abort', '#2=late:9', '#4=cancel']),
        answers=st.lists(st.tuples(SECONDS, st.integers(0, 5)), min_size=1, max_size=4),
        pause=st.tuples(SECONDS, SECONDS),
        marks=MARKS,
    )
    def holds(
        unready: tuple[float, float],
        works: float,
        fault: str,
        answers: list[tuple[float, int]],
        pause: tuple[float, float],
        marks: list[int],
    ) -> None:
        faults = {'a1': not_ready(unready[0]), 'a2': fault, 'a3': not_ready(unready[1])}
        line = Line(topics=('a1', 'a3'), faults=faults, seconds={'a2': works + 0.1})
        run = line.begin(TEXT, 3)
        operate_by_hand(run, pause, answers)
        scripts = {'J': line.script(TEXT)}
        accounts(run.records, marks, line.cell, scripts)
        shown = accounts(run.records, ALL, line.cell, scripts)
        seen.update(loss.value for loss in shown.times.lost_us)
        seen['made'] += shown.produced

    holds()
    for name in ('starved', 'blocked', 'own_fault', 'operator', 'rework', 'setup', 'made'):
        assert seen[name], seen


def not_ready(seconds: float) -> str:
    """Return the fault of a component that is not ready for so long after its second task."""
    return f'#2=not_ready:{seconds + 2.5}'


def operate_by_hand(
    run: VirtualRun, pause: tuple[float, float], answers: list[tuple[float, int]]
) -> None:
    """Pause a line once, and answer its holds, each after a while."""
    run.go(until=pause[0])
    wait(run, pause[0])
    assert run.pause().accepted
    wait(run, pause[1])
    assert run.resume().accepted
    run.go()
    for delay, which in answers * 4:
        if run.ended:
            break
        wait(run, delay)
        (hold,) = run.state.holds.values()
        run.answer(hold.answers[which % len(hold.answers)], hold.id)
        run.go()


def wait(run: VirtualRun, seconds: float) -> None:
    """Let so much time pass."""
    run.sim.clock.call_at(run.now + seconds, lambda: None)
    run.go(until=run.now + seconds)


@examples(3, 300)
@given(lines(), MARKS)
def test_drawn_lines(plan: Plan, marks: list[int]) -> None:
    """Several jobs and scripts, rounds, stops, aborts, components out of service."""
    bench = ProductBench(plan)
    operate(bench, plan.moments)
    scripts = {job: bench.scripts[name] for job, name in bench.accepted.items()}
    if bench.run.records:
        accounts(bench.run.records, marks, bench.cell, scripts)


@examples(4, 300)
@given(lines(), MARKS, drawn_steps())
def test_a_clock_that_is_set_changes_no_figure(plan: Plan, marks: list[int], steps: Steps) -> None:
    bench = ProductBench(plan)
    operate(bench, plan.moments)
    if bench.run.records:
        stepped_accounts(bench.run.records, marks, steps)


@examples(3, 300)
@given(
    lines(), MARKS, st.lists(st.tuples(st.integers(1, 99), st.booleans()), min_size=1, max_size=4)
)
def test_restarts_of_the_node(
    plan: Plan, marks: list[int], restarts: list[tuple[int, bool]]
) -> None:
    bench = ProductBench(plan)
    operate(bench, plan.moments)
    scripts = {job: bench.scripts[name] for job, name in bench.accepted.items()}
    if bench.run.records:
        accounts(restarted(bench.run.records, restarts), marks, bench.cell, scripts)


def restarted(
    records: Sequence[dict[str, Any]], restarts: Sequence[tuple[int, bool]]
) -> list[dict[str, Any]]:
    """Return records with starts of a node between them.

    :param restarts: shares of the records, in hundredths, and whether the node told its end
    """
    due: dict[int, bool] = {share * len(records) // 100: tells for share, tells in restarts}
    events: list[e.Event] = []
    for number, record in enumerate(records):
        event = from_record(record)
        if number in due and events:
            if due[number]:
                events.append(e.OrchestratorStopping().stamped(0, events[-1].time))
            between = (events[-1].time + event.time) / 2
            began = e.OrchestratorStarted(cell='test_line', digest='d')
            events.append(began.stamped(0, between))
        events.append(event)
    return [to_record(entry.stamped(seq, entry.time)) for seq, entry in enumerate(events, start=1)]


NIGHT = """
shifts:
  night: {from: 22:00, to: 06:00, breaks: [{from: 01:30, to: 03:15}]}
zone: Europe/Berlin
"""
HOUR_S = 3600.0


@examples(3, 300)
@given(lines(), st.sampled_from([date(2026, 3, 28), date(2026, 10, 24), date(2026, 5, 18)]))
def test_nights_on_which_the_clocks_change(plan: Plan, day: date) -> None:
    bench = ProductBench(plan)
    operate(bench, plan.moments)
    if not bench.run.records:
        return
    zone = ZoneInfo('Europe/Berlin')
    begin = datetime(day.year, day.month, day.day, 21, tzinfo=zone).timestamp()
    stretch = 11 * HOUR_S / max(bench.run.records[-1]['time'], 1.0)
    shifts = parse_shifts(NIGHT, 'shifts.yaml')
    period = shift_on(shifts.shifts['night'], day, zone_of(shifts))
    assert list(period.planned.pieces) == naive_night(begin, zone)
    whole = (from_record(entry) for entry in bench.run.records)
    slow = (entry.stamped(entry.seq, round(begin + entry.time * stretch, 1)) for entry in whole)
    events = [entry for entry in slow if us_of(entry.time) <= period.end_us]
    shown = figures(times_of(events, period.planned, period.end_us), Paces(None))
    records = [to_record(entry) for entry in events]
    naive = naive_account(records, period.planned.pieces, lambda _: Fraction(0))
    booked = {loss.value: us for loss, us in shown.times.lost_us.items()}
    assert +Counter({**booked, 'production': shown.times.producing_us}) == +naive.times
    agrees(shown, naive)


def naive_night(begin: float, zone: ZoneInfo) -> list[tuple[int, int]]:
    """Return the planned time of the night: each minute by what the clock showed."""
    pieces: list[tuple[int, int]] = []
    for number in range(12 * 60):
        moment = round(begin) + 60 * number
        shown = datetime.fromtimestamp(moment, zone)
        clock = shown.hour * 60 + shown.minute
        if (clock >= 22 * 60 or clock < 6 * 60) and not 90 <= clock < 195:
            span = (moment * 1_000_000, (moment + 60) * 1_000_000)
            if pieces and pieces[-1][1] == span[0]:
                span = (pieces.pop()[0], span[1])
            pieces.append(span)
    return pieces
