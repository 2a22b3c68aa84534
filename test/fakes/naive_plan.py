"""What a cell file and a script say, as plain rows for the naive cell (docs/formats.md)."""

from __future__ import annotations

import math
import re
from typing import Any

Row = dict[str, Any]


def task_row(task: Row, default_id: str, device: Row) -> Row:
    """Return a task with every default filled in."""
    policy = 'continue' if task.get('continue_if_fail') else task.get('on_failure', 'hold')
    timeout = task.get('timeout', device.get('timeout', 300.0))
    return {
        'qty_change': 0,
        'requires_conveyor': True,
        'retries': 0,
        'retry_delay': 0.0,
        'runs_for': 'good',
        'repeatable': False,
        'once': False,
        'args': {},
        'task': 'TASK_A',
        'id': default_id,
        **task,
        'policy': policy,
        'timeout': math.inf if timeout == 'none' else timeout,
        'device': device['name'],
        'zones': [],
    }


def cell_rows(cell: Row) -> Row:
    """Return the belt and the devices by action name, each with its sections."""
    devices = {}
    named = {**cell['components'], 'conveyor': cell['conveyor']}
    for name, found in named.items():
        places = found.get('section', [])
        places = places if isinstance(places, list) else [places]
        devices[found['action']] = {**found, 'name': name, 'places': places}
    return {'size': cell['conveyor']['sections'], 'devices': devices}


def script_rows(script: Row, cell: Row) -> Row:
    """Return the task lists, steps as lists of members, members as lists of tasks."""
    devices = cell['devices']
    lists: dict[int, Any] = {}
    early: dict[int, bool] = {}
    for number, given in script['sections'].items():
        listed = given['tasks'] if isinstance(given, dict) else given
        release = given.get('release_conveyor') if isinstance(given, dict) else None
        early[number] = release == 'after_last_conveyor_task'
        count = 0
        lists[number] = []
        for step in listed:
            members = []
            for member in step.get('parallel', [step]):
                rows = []
                for task in member if isinstance(member, list) else [member]:
                    count += 1
                    rows.append(task_row(task, f'{number}.{count}', devices[task['action']]))
                members.append(rows)
            lists[number].append(members)
    first = [
        task_row(task, f'init.{n}', devices[task['action']])
        for n, task in enumerate(script.get('initialization', []), 1)
    ]
    by_id = {t['id']: t for steps in lists.values() for s in steps for m in s for t in m}
    for name, ids in script.get('zones', {}).items():
        for row in [*by_id.values(), *first]:
            row['zones'] += [name] if row['id'] in ids else []
    links = [{'capacity': 1, 'initial': 0, **d} for d in script.get('lateral_dependencies', [])]
    order = [
        (d['upstream'], d['downstream']) for d in script.get('initialization_dependencies', [])
    ]
    for task in first:
        task['after'] = [upstream for upstream, downstream in order if downstream == task['id']]
    return {
        'lists': lists,
        'early': early,
        'first': first,
        'flags': links,
        'source': next(t for t in _with_places(lists) if t[1]['qty_change'] == 1)[0],
        'sink': max(n for n, t in _with_places(lists) if t['qty_change'] == -1),
    }


def _with_places(lists: dict[int, Any]) -> list[tuple[int, Row]]:
    return [(n, t) for n, steps in lists.items() for s in steps for m in s for t in m]


def needs_belt(step: list[list[Row]]) -> bool:
    """Tell whether a step requires the conveyor: a group does if any member does (3.3)."""
    return any(task['requires_conveyor'] for member in step for task in member)


class MissingResult(Exception):
    """A reference to a result that this item does not have (6.3)."""


def value_of(text: Any, job: Row, item: Row | None) -> Any:
    """Return what a reference stands for; any other value is itself."""
    match = re.fullmatch(r'\$\{(.*)\}', text) if isinstance(text, str) else None
    if match is None:
        return text
    part, _, rest = match[1].partition('.')
    if part == 'params':
        return job['params'][rest]
    if part == 'order':
        return {'id': job['id'], 'quantity': job['quantity']}[rest]
    assert item is not None
    if part == 'item':
        return {'id': item['id'], 'number': item['number']}[rest]
    task, _, field = rest.rpartition('.')
    if task not in item['results']:
        raise MissingResult
    return item['results'][task][field]


def wanted(task: Row, job: Row, item: Row | None) -> bool:
    """Tell what `when` and `unless` say (6.5)."""
    for key, needed in (('when', True), ('unless', False)):
        if key in task:
            test = task[key] if isinstance(task[key], dict) else {'value': task[key]}
            found = value_of(test['value'], job, item)
            if (found == test.get('equals', True)) is not needed:
                return False
    return True


def fault_of(device: Row, task: str, nth: int, nth_of_task: int) -> tuple[str, float | None]:
    """Return what strikes at a goal, and its seconds; '' for none."""
    for text in device.get('faults', []):
        match = re.fullmatch(r'(\w*?)(?:#(\d+|\*))?=(\w+)(?::(.*))?', text)
        assert match is not None, text
        count = nth_of_task if match[1] else nth
        if match[1] in ('', task) and (match[2] or '1') in ('*', str(count)):
            return match[3], float(match[4]) if match[4] else None
    return '', None
