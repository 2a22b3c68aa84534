"""A second opinion on the account of a period, written from docs/account.md.

It shares nothing with the product's account: for each stretch between two events it looks through
all that was recorded before it, and asks the questions of the page one after another.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

from fakes.naive_causes import OF_COMPONENTS, NaiveCauses, naive_causes

Records = Sequence[Mapping[str, Any]]

BEGINS = ('Execute', 'Suspending', 'Suspended', 'Unsuspending')
UNPLANNED = ('not_recorded', 'no_order', 'orders_wait')
PRODUCES = ('production', 'rework')
JOB_ENDS = ('job.completed', 'job.aborted', 'job.removed')


class NaiveComponents(NamedTuple):
    """What each component worked, and how it failed."""

    operated: Counter[str]
    failures: Counter[str]
    down: Counter[str]
    repair: Counter[str]


class NaiveAccount(NamedTuple):
    """What the period was worth."""

    times: Counter[str]
    """Microseconds of each loss, and of `production`."""
    good: int
    produced: int
    oee: Fraction | None
    parts: Counter[str]
    """Microseconds of each part of a loss."""
    components: NaiveComponents
    causes: NaiveCauses


def naive_account(
    records: Records, planned: Sequence[tuple[int, int]], pace_us: Callable[[str], Fraction]
) -> NaiveAccount:
    """Return the account of some stretches of time.

    :param records: of a whole journal
    :param pace_us: of a job
    """
    times: Counter[str] = Counter()
    loss_parts: Counter[str] = Counter()
    parts = NaiveComponents(Counter(), Counter(), Counter(), Counter())
    failed: set[str] = set()
    for number, record in enumerate(records):
        begin = us(record)
        is_last = number + 1 == len(records)
        end = planned[-1][1] if is_last else before_a_step(records[number + 1])
        if overlap(begin, end, planned):
            after = records[number + 1]['event'] if number + 1 < len(records) else ''
            past, took = records[: number + 1], overlap(begin, end, planned)
            what = what_is_it(past, after)
            times[what] += took
            loss_parts[part_of(past, what)] += took
            of_components(past, what, took, parts, failed)
        if record['event'] == 'hold.raised' and failing(records, record):
            is_busy = number > 0 and what_is_it(records[:number], '') not in UNPLANNED
            if is_busy and is_planned(left_at(records, number), planned):
                failed.add(record['hold'])
    for record in records:
        if record['event'] == 'hold.raised' and record['hold'] in failed:
            parts.failures[record['component']] += 1
    times['not_recorded'] += overlap(min(planned)[0], us(records[0]), planned)
    out = [item for item in records if item['event'] == 'item.removed']
    counts = [is_planned(left_at(records, number), planned) for number in range(len(records))]
    counted = [item for item in out if counts[records.index(item)]]
    good = [item for item in counted if is_good(item, records)]
    busy = sum(times.values()) - sum(times[name] for name in UNPLANNED)
    value = sum((pace_us(item['job']) for item in good), start=Fraction(0))
    oee = value / busy if busy else None
    causes = naive_causes(records, counts)
    return NaiveAccount(times, len(good), len(counted), oee, loss_parts, parts, causes)


def part_of(past: Records, what: str) -> str:
    """Return the part of a loss; empty: it has none."""
    standing, reason = holds(past), last(past, 'cell.stop_reason_changed', 'stop_reason')
    if what == 'own_fault':
        return 'fault' if standing and failing(past, standing[0]) else 'answer'
    if what != 'operator':
        return ''
    if is_manual(past):
        return 'manual'
    if reason == 'operator':
        return 'paused' if standing else 'not_started'
    return 'paused' if last(past, 'cell.state_changed', 'state') in BEGINS else 'not_started'


def of_components(
    past: Records, what: str, took: int, parts: NaiveComponents, failed: set[str]
) -> None:
    """Add what components did in a stretch of time that was booked as something."""
    if what in UNPLANNED:
        return
    if what != 'no_node':
        for name in {task['component'] for task in in_flight(past)}:
            parts.operated[name] += took
    standing = holds(past)
    for hold in standing:
        if failing(past, hold):
            parts.down[hold['component']] += took
            failed.add(hold['hold'])
    reason = last(past, 'cell.stop_reason_changed', 'stop_reason')
    is_stop = what == reason and not is_manual(past)
    if standing and is_stop and what in ('own_fault', 'operator') and failing(past, standing[0]):
        parts.repair[standing[0]['component']] += took


def holds(past: Records) -> list[Mapping[str, Any]]:
    """Return those that stand, the oldest first."""
    over = [record['hold'] for record in past if record['event'] == 'hold.released']
    raised = [record for record in past if record['event'] == 'hold.raised']
    return [record for record in raised if record['hold'] not in over]


def failing(records: Records, hold: Mapping[str, Any]) -> bool:
    """Tell whether a hold is a failure of its component."""
    past = records[: records.index(hold)]
    is_emergency = last(past, 'cell.stop_reason_changed', 'stop_reason') == 'emergency'
    is_cancelled = is_emergency or has_stopped(past)
    return bool(hold.get('component')) and hold['reason'] in OF_COMPONENTS and not is_cancelled


def is_planned(moment: int, planned: Sequence[tuple[int, int]]) -> bool:
    return any(here < moment <= there for here, there in planned)


STOPS = ('no_node', 'own_fault', 'operator', 'starved', 'blocked', 'emergency', 'setup', 'waiting')
LEAST_STOP_US = 50_000


class NaiveStop(NamedTuple):
    """A stop of the line."""

    seq: int
    loss: str
    hold: str
    begin: int
    end: int
    us: int
    """Planned time of it."""


def naive_stops(records: Records, planned: Sequence[tuple[int, int]]) -> list[NaiveStop]:
    """Return the stops of a whole journal, in their order, that are long enough.

    Of a clock that was never set.
    """
    why = [why_it_stands(records[: number + 1], '') for number in range(len(records))]
    stops: list[NaiveStop] = []
    before: object = None
    starts = 0
    for number, record in enumerate(records):
        is_last = number + 1 == len(records)
        begin, end = us(record), planned[-1][1] if is_last else us(records[number + 1])
        after = '' if is_last else records[number + 1]['event']
        starts = number if record['event'] == 'orchestrator.started' else starts
        if begin >= end:
            continue
        cause = why_it_stands(records[: number + 1], after)
        if cause is not None and cause == before:
            stops[-1] = stops[-1]._replace(end=end)
        elif cause is not None:
            first = number
            while first > starts and why[first - 1] == cause:
                first -= 1
            is_killed = cause != why[number] and after == 'orchestrator.started'
            seq = records[number + 1]['seq'] - 1 if is_killed else records[first]['seq']
            stops.append(NaiveStop(seq, str(cause[0]), str(cause[-1]), begin, end, 0))
        before = cause
    planned_us = [stop._replace(us=overlap(stop.begin, stop.end, planned)) for stop in stops]
    return [stop for stop in planned_us if stop.us and stop.end - stop.begin >= LEAST_STOP_US]


def naive_code(stop: NaiveStop, records: Records) -> str:
    """Return the reason of a stop; empty: it is not classified."""
    coded = [row for row in records if row['event'] == 'operator.decided' and row.get('code')]
    named = [row for row in coded if row.get('stop', '').endswith(f':{stop.seq}')]
    answers = [row for row in coded if stop.hold and row.get('hold') == stop.hold]
    if named or answers:
        return str((named or answers)[-1]['code'])
    codes = [
        code_now(records[: number + 1])
        for number, row in enumerate(records[:-1])
        if stop.begin <= us(row) < stop.end and us(row) < us(records[number + 1])
    ]
    return next(filter(None, reversed(codes)), '')


def code_now(past: Records) -> str:
    """Return the reason of the decision for which the line stands after some records."""
    loss, *about = why_it_stands(past, '') or ('',)
    decisions = [record for record in past if record['event'] == 'operator.decided']
    of_cell = [record for record in decisions if not {'job', 'component'} & record.keys()]
    if loss in ('own_fault', 'operator') and about[-1] and not is_manual(past):
        raised = next(n for n, record in enumerate(past) if record.get('hold') == about[-1] and n)
        is_pause = past[raised].get('reason') == 'paused'
        before = past[raised - 1]
        return str(before.get('code', '')) if is_pause and before.get('answer') == 'pause' else ''
    if loss == 'emergency':
        return code_since(of_cell, ['abort'], ['start', 'clear'])
    if loss == 'waiting':
        first = next(iter((*out_of_service(past), *unready(past))), '')
        of_it = [record for record in decisions if record.get('component') == first]
        return code_since(of_it, ['out_of_service'], ['in_service'])
    works = last(past, 'cell.state_changed', 'state') in BEGINS
    if loss == 'operator' and works and not last(past, 'cell.stop_reason_changed', 'stop_reason'):
        return code_since([record for record in decisions if 'job' in record], ['pause'], [])
    return code_since(of_cell, ['stop'], ['start', 'clear']) if loss == 'operator' else ''


def code_since(decisions: Records, words: Sequence[str], ends: Sequence[str]) -> str:
    """Return the reason that came with the last of some commands; empty: it is over."""
    matches = [decision for decision in decisions if decision['answer'] in (*words, *ends)]
    return str(matches[-1].get('code', '')) if matches and matches[-1]['answer'] in words else ''


def why_it_stands(past: Records, next_event: str) -> tuple[Any, ...] | None:
    """Return what the line stands for: the loss, the exact cause, and the hold; None: nothing."""
    loss = what_is_it(past, next_event)
    if loss not in STOPS:
        return None
    holds = {record['hold']: record for record in past if record['event'] == 'hold.raised'}
    for record in past:
        if record['event'] == 'hold.released':
            holds.pop(record['hold'], None)
    reason = last(past, 'cell.stop_reason_changed', 'stop_reason')
    if is_manual(past):
        return loss, 'manual'
    if loss in ('own_fault', 'operator') and reason and holds:
        return loss, next(iter(holds))
    if loss in ('starved', 'blocked', 'waiting'):
        return loss, unready(past), out_of_service(past), ''
    if loss == 'operator':
        words = last(past, 'cell.stop_reason_changed', 'reason') if reason else ''
        state = last(past, 'cell.state_changed', 'state')
        return loss, words, '' if reason or state in BEGINS else state, ''
    return loss, ''


def unready(past: Records) -> tuple[str, ...]:
    """Return the components that are not ready, the first first."""
    components: dict[str, None] = {}
    for record in past:
        if record['event'] == 'component.state_changed':
            if record.get('ready', False):
                components.pop(record['component'], None)
            else:
                components[record['component']] = None
    return tuple(components)


def out_of_service(past: Records) -> tuple[str, ...]:
    components: dict[str, None] = {}
    for record in past:
        if record['event'] == 'component.out_of_service':
            components[record['component']] = None
        elif record['event'] == 'component.in_service':
            components.pop(record['component'], None)
    return tuple(components)


def us(record: Mapping[str, Any]) -> int:
    return round(float(record['time']) * 1_000_000)


def before_a_step(record: Mapping[str, Any]) -> int:
    """Return the time of a record; of a step: what the clock showed before it."""
    is_step = record['event'] == 'clock.stepped'
    return us(record) - (round(record['seconds'] * 1_000_000) if is_step else 0)


def left_at(records: Records, number: int) -> int:
    """Return when an item left; at the moment of a step the clock is not set yet."""
    time = us(records[number])
    for record in reversed(records[:number]):
        if us(record) != time:
            break
        time = before_a_step(record)
    return time


def overlap(begin: int, end: int, planned: Sequence[tuple[int, int]]) -> int:
    return sum(max(0, min(end, there) - max(begin, here)) for here, there in planned)


def is_good(out: Mapping[str, Any], records: Records) -> bool:
    let_pass = any(
        row['item'] == out['item']
        for row in records[: records.index(out)]  # a later mark changes no count
        if row['event'] == 'item.nonconforming'
        or (row['event'] == 'task.continued' and row['policy'] == 'continue' and row.get('item'))
    )
    return out['how'] == 'packed' and not let_pass


# --- where the time goes --------------------------------------------------------------------


def is_manual(past: Records) -> bool:
    """Tell whether the cell stands in manual mode, and was not aborted there."""
    reason = last(past, 'cell.stop_reason_changed', 'stop_reason')
    mode = last(past, 'cell.unit_mode_changed', 'mode')
    return bool(mode == 'manual' and reason != 'emergency')


def what_is_it(past: Records, next_event: str) -> str:
    """Say what the time after some records is booked as."""
    if not any(has_work(past, job) for job in jobs(past)):
        return 'orders_wait' if jobs(past) else 'no_order'
    if next_event == 'orchestrator.started' or has_stopped(past):
        return 'no_node'
    reason = last(past, 'cell.stop_reason_changed', 'stop_reason')
    if is_manual(past):
        return 'operator'
    if reason:
        return str(reason)
    if last(past, 'cell.state_changed', 'state') not in BEGINS:
        return 'operator'
    flying = in_flight(past)
    if not flying:
        line = [job for job in jobs(past) if is_on_the_line(past, job)]
        paused = [job for job in line if is_paused(past, job)]
        return 'operator' if line and paused == line else 'waiting'
    if all('job' in task and 'section' not in task for task in flying):
        return 'setup'
    if any(task['attempt'] > 1 or task.get('round', 0) > 0 for task in flying):
        return 'rework'
    return 'production'


def last(past: Records, event: str, field: str) -> Any:
    values = [record.get(field) for record in past if record['event'] == event]
    return values[-1] if values else None


def has_stopped(past: Records) -> bool:
    ends = [record for record in past if record['event'].startswith('orchestrator.')]
    return bool(ends) and ends[-1]['event'] == 'orchestrator.stopping'


def in_flight(past: Records) -> list[Mapping[str, Any]]:
    begun: dict[Any, Mapping[str, Any]] = {}
    for record in past:
        key = tuple(record.get(name) for name in ('job', 'section', 'item', 'task'))
        if record['event'] == 'task.started':
            begun[key] = record
        elif record['event'] in ('task.succeeded', 'task.failed'):
            begun.pop(key, None)
    return list(begun.values())


def jobs(past: Records) -> list[str]:
    named = [record['job'] for record in past if record['event'] == 'job.queued']
    ended = [record['job'] for record in past if record['event'] in JOB_ENDS]
    return [job for job in named if job not in ended]


def of_job(past: Records, job: str, *events: str) -> list[str]:
    return [row['event'] for row in past if row.get('job') == job and row['event'] in events]


def is_on_the_line(past: Records, job: str) -> bool:
    return bool(of_job(past, job, 'job.started', 'job.aborting'))


def is_paused(past: Records, job: str) -> bool:
    words = ('job.paused', 'job.resumed', 'job.stopping', 'job.aborting')
    return of_job(past, job, *words)[-1:] == ['job.paused']


def has_work(past: Records, job: str) -> bool:
    """Tell whether a job is on the line, or may start."""
    if is_on_the_line(past, job):
        return True
    (queued,) = (row for row in past if row['event'] == 'job.queued' and row['job'] == job)
    updates = [row for row in past if row['event'] == 'job.updated' and row['job'] == job]
    newest = updates[-1] if updates else queued
    since = past.index(newest)
    held = of_job(past, job, 'job.held', 'job.released')[-1:]
    is_held = held == ['job.held'] if held else queued.get('held', False)
    may = of_job(past[since:], job, 'job.may_start')
    awaits = newest.get('awaits_start', False) and not may
    lacks = set(newest.get('unavailable', ()))
    for row in past[since:]:
        if row['event'] == 'component.out_of_service' and job in row.get('jobs', ()):
            lacks.add(row['component'])
        elif row['event'] == 'component.in_service':
            lacks.discard(row['component'])
    released = [row['digest'] for row in past[since:] if row['event'] == 'script.released']
    unreleased = newest.get('awaits_release', False) and newest['digest'] not in released
    return not (is_held or awaits or lacks or unreleased)
