"""What the naive cell works on: a script as plain rows, and jobs, items, tasks and holds."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

Row = dict[str, Any]

DEFAULTS: Row = {
    'qty_change': 0,
    'requires_conveyor': True,
    'retries': 0,
    'retry_delay': 0.0,
    'runs_for': 'good',
    'repeatable': False,
    'once': False,
    'args': {},
}


def task_row(task: Row, default_id: str, device: Row) -> Row:
    """Return a task with every default filled in."""
    policy = task.get('on_failure', 'hold')
    timeout = task.get('timeout', device.get('timeout', 300.0))
    row = {**DEFAULTS, 'id': default_id, **task, 'policy': policy, 'timeout': timeout}
    return row | {'device': device['name'], 'zones': [], 'after': []}


def plan_of(script: Row, devices: Row) -> Row:
    """Return a script's lists: steps as lists of members, members as lists of tasks."""
    lists: dict[int, Any] = {}
    early: dict[int, bool] = {}
    for number, given in script['sections'].items():
        whole = given if isinstance(given, dict) else {'tasks': given}
        early[number] = whole.get('release_conveyor') == 'after_last_conveyor_task'
        members = [
            [m if isinstance(m, list) else [m] for m in step.get('parallel', [step])]
            for step in whole['tasks']
        ]
        lists[number] = [
            [[task_row(t, '', devices[t['action']]) for t in tasks] for tasks in step]
            for step in members
        ]
    first = [task_row(t, '', devices[t['action']]) for t in script.get('initialization', [])]
    placed = [(n, t) for n, steps in lists.items() for s in steps for m in s for t in m]
    for name, ids in script.get('zones', {}).items():
        for row in [*first, *(task for _, task in placed)]:
            row['zones'] += [name] if row['id'] in ids else []
    by_id = {task['id']: task for task in first}
    for link in script.get('initialization_dependencies', []):
        by_id[link['downstream']]['after'].append(by_id[link['upstream']])
    return {
        'lists': lists,
        'early': early,
        'first': first,
        'flags': [
            {'capacity': 1, 'initial': 0, **d} for d in script.get('lateral_dependencies', [])
        ],
        'source': next(n for n, task in placed if task['qty_change'] == 1),
        'sink': max(n for n, task in placed if task['qty_change'] == -1),
    }


def needs_belt(step: list[list[Row]]) -> bool:
    """Tell whether a step requires the conveyor: a group does if any member does (3.3)."""
    return any(task['requires_conveyor'] for member in step for task in member)


@dataclass(eq=False)
class Job:
    """A work order."""

    id: str
    plan: Row
    quantity: int
    begun: int = 0
    started: bool = False
    aborting: bool = False
    over: bool = False
    items: list[Item] = field(default_factory=list)

    @property
    def left(self) -> int:
        """Source cycles that are left."""
        return 0 if self.aborting else self.quantity - self.begun


@dataclass(eq=False)
class Item:
    """What one source cycle makes; `empty`: an empty position."""

    job: Job
    number: int
    rejected: bool = False
    standing: bool = False
    missing: bool = False
    gone: str = ''
    results: Row = field(default_factory=dict)
    handled: set[int] = field(default_factory=set)
    turned: set[int] = field(default_factory=set)

    @property
    def id(self) -> str:
        return f'{self.job.id}/{self.number}'

    @property
    def empty(self) -> bool:
        return self.missing or bool(self.gone)


@dataclass(eq=False)
class Work:
    """A task of an item, of a job's initialization, or the belt's move."""

    task: Row
    job: Job | None = None
    section: int | None = None
    item: Item | None = None
    state: str = 'new'
    attempt: int = 0
    after: float = 0.0
    cause: str = ''
    reason: str = ''
    deaf: bool = True

    @property
    def where(self) -> Row:
        """Where a record says that it is."""
        row: Row = {'job': self.job and self.job.id, 'section': self.section}
        row |= {'item': self.item and self.item.id, 'task': self.task['id']}
        return {name: value for name, value in row.items() if value is not None}

    @property
    def links(self) -> list[Row]:
        """The flags of its script."""
        return self.job.plan['flags'] if self.job and self.item else []


@dataclass(eq=False)
class Hold:
    """What waits for an operator."""

    where: Row
    reason: str
    answers: list[str]
    work: Work | None = None


class MissingResult(Exception):
    """A reference to a result that this item does not have (6.3)."""


def value_of(text: Any, item: Item) -> Any:
    """Return what a reference stands for; any other value is itself."""
    match = re.fullmatch(r'\$\{(.*)\}', text) if isinstance(text, str) else None
    if match is None:
        return text
    if match[1] == 'item.number':
        return item.number
    _, task, name = match[1].split('.')
    if task not in item.results:
        raise MissingResult
    return item.results[task][name]


def wanted(task: Row, item: Item) -> bool:
    """Tell what `when` and `unless` say (6.5)."""
    for key, needed in (('when', True), ('unless', False)):
        if key in task:
            test = task[key] if isinstance(task[key], dict) else {'value': task[key]}
            if (value_of(test['value'], item) == test.get('equals', True)) is not needed:
                return False
    return True
