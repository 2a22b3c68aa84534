"""What the rules say of one task, whatever else is on the line.

Like the naive cell, which asks them, written from the page and not from the product.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from fakes.naive_plan import Row
from fakes.naive_run import Item, Job, Task


def is_skipped(given: Row, item: Item) -> bool:
    """Tell whether a task is skipped (3.2, 6.4, 6.5; KeyError: a result is missing, 6.3)."""
    if not is_for(given, item):
        return True
    for test, needed in ((given.get('when'), True), (given.get('unless'), False)):
        if test is not None and holds(test, item) != needed:
            return True
    judged = named(given.get('fails_unless', []))
    others = [term for term in judged if f'results.{given["id"]}.' not in str(term)]
    for value in (*given.get('args', {}).values(), *others):
        item.value(value)
    return False


def refuses(task: Task, results: Row) -> bool:
    """Tell whether the verdict of a task refuses its results (2.8)."""
    own = {f'results.{task.id}.{name}': value for name, value in results.items()}
    test = task.given.get('fails_unless')
    try:
        return bool(test) and not holds(
            test, replace(task.item, values={**task.item.values, **own})
        )
    except KeyError:
        return True


def serial_in(task: Task, results: Row | None) -> str:
    """Return the serial that a task has read; '': none (6.8)."""
    return str((results or {}).get(task.given.get('identifies', ''), ''))


def named(test: Any) -> list[Any]:
    """Return what a condition names."""
    if isinstance(test, dict):
        return named([test.get('value', ''), *test.get('all', []), *test.get('any', [])])
    return [name for part in test for name in named(part)] if isinstance(test, list) else [test]


def holds(test: Any, item: Item) -> bool:
    """Tell whether a condition holds (6.5; KeyError: a value in it is missing, or not finite)."""
    if isinstance(test, str):
        return item.value(test) is True
    for joint, enough in (('all', all), ('any', any)):
        if joint in test:
            return enough([holds(part, item) for part in test[joint]])
    value = item.value(test['value'])
    low, high = test.get('between', (test.get('at_least', value), test.get('at_most', value)))
    wanted = test.get('one_of', [test.get('equals', value)])
    return value in wanted and value != test.get('not_equals') and low <= value <= high


def is_for(given: Row, item: Item) -> bool:
    """Tell whether a task is for an item: it is there, and good or rejected (3.2, 6.4)."""
    state = 'rejected' if item.rejected else 'good'
    out_twice = given.get('qty_change') == -1 and not item.place
    return not (item.empty or out_twice) and given.get('runs_for', 'good') in ('all', state)


def needs_belt(step: list[list[Task]]) -> bool:
    """Tell whether a step requires the conveyor: a group does if any member does (3.3)."""
    return any(task.given.get('requires_conveyor', True) for member in step for task in member)


def may_repeat(task: Task) -> bool:
    """Tell whether a refused result begins another round (3.9)."""
    if not task.repeat or task.reason != 'result_refused' or task.cancelled or task.job.aborting:
        return False
    return task.repeat.begun < task.repeat.times and has_rounds(task)


def has_rounds(task: Task) -> bool:
    """Tell whether rounds may begin: for good items, of a job that is not being aborted (3.9)."""
    return is_for(task.given, task.item) and not (task.item.rejected or task.job.aborting)


def verdict(task: Task) -> str:
    """Say what is to be done about a failed attempt; the last word counts (2.6, 2.7, 3.9)."""
    what = task.given.get('on_failure', 'hold')
    if may_repeat(task):
        return 'again'
    is_once = task.repeat and task.reason == 'result_refused'
    if (
        not is_once
        and task.attempt <= task.given.get('retries', 0)
        and task.reason != 'missing_result'
    ):
        what = 'retry'
    if task.cancelled == 'abort_job':
        what = 'hold' if is_open(task) else 'abort_job'
    if task.cancelled == 'abort':
        what = 'hold'
    lost = task.reason == 'server_lost' and not task.given.get('repeatable')
    if task.reason in ('in_doubt', 'duplicate_serial', 'setup_missing') or lost:
        what = 'hold'
    return str(what)


def is_open(task: Task) -> bool:
    """Tell whether nobody knows if a task has placed its item or taken it out (4.3, 7.1)."""
    cut_off = task.cancelled in ('abort_job', 'abort')
    unknown = task.reason in ('in_doubt', 'server_lost') or cut_off
    begun = task.reason not in ('goal_rejected', 'missing_result', 'setup_missing')
    return bool(task.given.get('qty_change')) and unknown and begun


def answers(task: Task, on_the_belt: Iterable[Job], *, needless: bool) -> list[str]:
    """Return what makes sense as an answer about a held task now (7.1); a move has no job.

    :param needless: it is initialization that its job needs no more (6.6)
    """
    job, item, slot_in_doubt = task.job, task.item, is_open(task)
    again = not needless if not item else is_for(task.given, item)
    again = again and not (slot_in_doubt and task.cancelled == 'abort_job')
    good = item and item.place and not (item.empty or item.rejected)
    jobs = [job] if job else on_the_belt
    lacks = task.reason == 'setup_missing'
    sensible = {
        'retry': again and task.reason != 'missing_result' and not lacks,
        'again': again and task.repeat and has_rounds(task) and not lacks,
        'change': again and lacks and not job.aborting,
        'mark_done': True,
        'skip': job and not (again and task.given.get('qty_change') == -1),
        'reject': good and not slot_in_doubt and task.id not in job.plan.trailing,
        'abort_job': not slot_in_doubt and not all(live_job.aborting for live_job in jobs),
    }
    return [answer for answer, fits in sensible.items() if fits]
