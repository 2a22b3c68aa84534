"""A second opinion on scrap, rework and components, written from docs/account.md alone.

It imports nothing of the product. For each item that left, each attempt and each hold it looks
through the records before it, and asks what the page says.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

Record = Mapping[str, Any]
Records = Sequence[Record]

COUNTED = ('nonconforming', 'rejected', 'by_hand')
OF_COMPONENTS = (
    'server_unavailable',
    'goal_rejected',
    'aborted',
    'timeout',
    'task_result_false',
    'server_lost',
    'in_doubt',
)


class Row(NamedTuple):
    """A cause of scrap or rework."""

    effect: str
    decision: str
    product: str
    task: str = ''
    component: str = ''
    reason: str = ''
    bound: str = ''


class Values(NamedTuple):
    """Measured values beside their bounds."""

    times: int
    below: int
    above: int
    least: float
    mean: Fraction
    greatest: float


class NaiveCauses(NamedTuple):
    """Why items were not good, and what was done again."""

    rows: Counter[Row]
    made: dict[str, Counter[str]]
    """By job: the kinds of items, `first_pass`, `attempts` and `rounds`."""
    measured: dict[tuple[Any, ...], Values]


def naive_causes(records: Records, counts: Sequence[bool]) -> NaiveCauses:
    """Return the causes in planned time.

    :param counts: of each record whether its moment is in planned time
    """
    rows: Counter[Row] = Counter()
    made: dict[str, Counter[str]] = {}
    values: dict[tuple[Any, ...], list[float]] = {}
    for number, record in enumerate(records):
        if not counts[number]:
            continue
        past = records[:number]
        if record['event'] == 'item.removed':
            kind, row = what_became(past, record)
            of_job = made.setdefault(record['job'], Counter())
            of_job[kind] += 1
            of_job['first_pass'] += kind == 'good' and is_first_pass(past, record)
            rows.update([row] if row else [])
        elif again := done_again(past, record):
            rows[again] += 1
            made.setdefault(record['job'], Counter())[f'{again.effect}s'] += 1
        for key, value in measured(past, record):
            values.setdefault(key, []).append(value)
    return NaiveCauses(rows, made, {key: beside(key, series) for key, series in values.items()})


# --- items ------------------------------------------------------------------------------------


def of_item(past: Records, item: Any) -> list[Record]:
    return [record for record in past if record.get('item') == item]


def what_became(past: Records, out: Record) -> tuple[str, Row | None]:
    """Return good, nonconforming, rejected or by_hand, and the cause."""
    about, product = of_item(past, out['item']), product_of(past, out['job'])
    if out['how'] == 'by_hand':
        return 'by_hand', Row('by_hand', 'remove_item', product)
    if out['how'] == 'rejected':
        return 'rejected', why_rejected(past, out, product)
    for record in about:
        number = past.index(record)
        if record['event'] == 'item.nonconforming':
            answers = [earlier['answer'] for earlier in past[:number] if is_decision(earlier)]
            decision = 'skip' if answers[-1:] == ['skip'] else 'mark_done'
        elif record['event'] == 'task.continued' and record['policy'] == 'continue':
            decision = 'on_failure'
        else:
            continue
        return 'nonconforming', failed(past[:number], record, 'nonconforming', decision, product)
    return 'good', None


def why_rejected(past: Records, out: Record, product: str) -> Row:
    rejections = [row for row in of_item(past, out['item']) if row['event'] == 'item.rejected']
    first = past.index(rejections[0]) if rejections else len(past)
    if any(row['event'] == 'job.aborting' and row['job'] == out['job'] for row in past[:first]):
        return Row('rejected', 'abort_job', product)
    for row in of_item(past[first:], out['item']):
        if row['event'] == 'task.continued' and row['policy'] == 'reject':
            before = past[: past.index(row)]
            decision = 'reject' if was_held(before, row) else 'on_failure'
            return failed(before, row, 'rejected', decision, product)
    return Row('rejected', 'on_failure', product)


def is_first_pass(past: Records, out: Record) -> bool:
    about = of_item(past, out['item'])
    holds = [row['hold'] for row in about if row['event'] == 'hold.raised']
    for row in past:
        if (
            is_decision(row)
            and row['answer'] in ('mark_done', 'skip')
            and row.get('hold') in holds
        ):
            return False
    return not any(
        row['event'] == 'round.begun'
        or (row['event'] == 'task.started' and (row['attempt'] > 1 or row.get('round', 0) > 0))
        for row in about
    )


def is_decision(record: Record) -> bool:
    return bool(record['event'] == 'operator.decided')


def product_of(past: Records, job: str) -> str:
    orders = [record for record in past if record['event'] in ('job.queued', 'job.updated')]
    newest = [record for record in orders if record['job'] == job][-1]
    return str(newest.get('recipe') or newest['script'])


# --- what was done again ----------------------------------------------------------------------


def done_again(past: Records, record: Record) -> Row | None:
    if record.get('item') is None:
        return None
    if record['event'] == 'task.started' and record['attempt'] > 1:
        decision = 'retry' if was_held(past, record) else 'retries'
        return failed(past, record, 'attempt', decision, product_of(past, record['job']))
    if record['event'] != 'round.begun':
        return None
    ends = [
        failure
        for failure in of_item(past, record['item'])
        if failure['event'] == 'task.failed' and failure['task'] in record['tasks']
    ]
    decision = 'again' if was_held(past, ends[-1]) else 'repeat'
    return failed(past, ends[-1], 'round', decision, product_of(past, record['job']))


def same_task(first: Record, other: Record) -> bool:
    return all(first.get(name) == other.get(name) for name in ('job', 'item', 'task'))


def last_failure(past: Records, about: Record) -> Record | None:
    """Return the last failed attempt of a task; a round begins anew."""
    failure = None
    for record in past:
        if record['event'] == 'task.failed' and same_task(record, about):
            failure = record
        elif record['event'] == 'round.begun' and record['item'] == about.get('item'):
            failure = None if about['task'] in record['tasks'] else failure
    return failure


def was_held(past: Records, about: Record) -> bool:
    failure = last_failure(past, about)
    since = past[past.index(failure) :] if failure is not None else []
    return any(record['event'] == 'hold.raised' and same_task(record, about) for record in since)


def failed(past: Records, about: Record, effect: str, decision: str, product: str) -> Row:
    failure = last_failure(past, about)
    if failure is None:
        component = about.get('component', '') if effect == 'attempt' else ''
        return Row(effect, decision, product, about['task'], component)
    number = past.index(failure)
    bound = ''
    if failure['reason'] == 'result_refused':
        parts = comparisons(past[:number], failure)
        bound = '; '.join(words for words, is_met, _ in parts if not is_met)
    component = component_of(past[:number], failure)
    return Row(effect, decision, product, about['task'], component, failure['reason'], bound)


def component_of(past: Records, end: Record) -> str:
    """Return the component of the attempt that ended; nothing may have been sent."""
    for record in reversed(past):
        if record['event'] in ('task.succeeded', 'task.failed') and same_task(record, end):
            return ''
        if record['event'] == 'task.started' and same_task(record, end):
            return str(record['component'])
    return ''


# --- verdicts ---------------------------------------------------------------------------------


def comparisons(past: Records, end: Record) -> Iterator[tuple[str, bool, Record]]:
    """Yield each comparison of a field of the own result: its words, and whether it is met."""
    orders = [record for record in past if record['event'] in ('job.queued', 'job.updated')]
    order = [record for record in orders if record['job'] == end['job']][-1]
    loaded = [record for record in past if record['event'] == 'script.loaded']
    script = [record for record in loaded if record['digest'] == order['digest']][-1]['definition']
    for task in tasks_in(script):
        if task.get('id') == end['task'] and 'fails_unless' in task:
            for part in parts_of(task['fails_unless']):
                if own_field(part, end['task']) is not None:
                    whole = {**part, **bounds(part, order.get('params', {}))}
                    yield words_of(whole), is_met(whole, end), whole


def tasks_in(plain: Any) -> Iterator[Record]:
    """Yield everything in a script that has an id."""
    if isinstance(plain, Mapping):
        if 'id' in plain:
            yield plain
        for member in plain.values():
            yield from tasks_in(member)
    elif isinstance(plain, list):
        for member in plain:
            yield from tasks_in(member)


def parts_of(verdict: Record) -> Iterator[Record]:
    parts = verdict.get('all') or verdict.get('any')
    if not parts:
        yield verdict
    for part in parts or ():
        yield from parts_of(part)


def own_field(part: Record, task: str) -> list[str] | None:
    text = part.get('value', {}).get('$', [])
    if len(text) != 1 or not isinstance(text[0], Mapping):
        return None
    is_own = (text[0]['source'], text[0]['name']) == ('results', task)
    return list(text[0].get('fields', ())) if is_own else None


def bounds(part: Record, params: Record) -> Record:
    limits = {}
    for name in ('at_least', 'at_most'):
        bound = part.get(name)
        if isinstance(bound, Mapping):
            bound = params[bound['$'][0]['name']]
        if bound is not None:
            limits[name] = bound
    return limits


def words_of(part: Record) -> str:
    reference = part['value']['$'][0]
    named = '.'.join((reference['source'], reference['name'], *reference.get('fields', ())))
    low, high = part.get('at_least'), part.get('at_most')
    if part.get('one_of'):
        compared = f' one of {", ".join(str(choice) for choice in part["one_of"])}'
    elif part.get('not_equals') is not None:
        compared = f' is not {part["not_equals"]}'
    elif low is not None and high is not None:
        compared = f' from {low} to {high}'
    elif low is not None:
        compared = f' at least {low}'
    elif high is not None:
        compared = f' at most {high}'
    else:
        equals = part.get('equals', True)
        compared = '' if equals is True else f' = {str(equals).lower()}'
    return f'${{{named}}}{compared}'


def value_of(part: Record, end: Record) -> Any:
    value = end.get('results', {})
    for name in part['value']['$'][0].get('fields', ()):
        value = value.get(name) if isinstance(value, Mapping) else None
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return (
        None if isinstance(value, Mapping) or (is_number and not math.isfinite(value)) else value
    )


def is_met(part: Record, end: Record) -> bool:
    value = value_of(part, end)
    low, high = part.get('at_least'), part.get('at_most')
    if value is None:
        return False
    if part.get('one_of'):
        return value in part['one_of']
    if part.get('not_equals') is not None:
        return bool(value != part['not_equals'])
    if low is None and high is None:
        return bool(value == part.get('equals', True))
    return (low is None or value >= low) and (high is None or value <= high)


def measured(past: Records, end: Record) -> Iterator[tuple[tuple[Any, ...], float]]:
    is_refused = end['event'] == 'task.failed' and end['reason'] == 'result_refused'
    if end.get('item') is None or not (is_refused or end['event'] == 'task.succeeded'):
        return
    for _, _, part in comparisons(past, end):
        value, low, high = value_of(part, end), part.get('at_least'), part.get('at_most')
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if is_number and (low is not None or high is not None):
            field = '.'.join(part['value']['$'][0].get('fields', ()))
            product, component = product_of(past, end['job']), component_of(past, end)
            yield (product, end['task'], component, field, low, high), value


def beside(key: tuple[Any, ...], starts_s: Sequence[float]) -> Values:
    low, high = key[-2:]
    below = sum(low is not None and value < low for value in starts_s)
    above = sum(high is not None and value > high for value in starts_s)
    mean = sum((Fraction(value) for value in starts_s), start=Fraction(0)) / len(starts_s)
    return Values(len(starts_s), below, above, min(starts_s), mean, max(starts_s))
