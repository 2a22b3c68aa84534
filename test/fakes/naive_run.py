"""What the rules of the naive cell work on: its state, the time, and the records."""

from __future__ import annotations

import itertools
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import inf, isfinite, isnan
from types import SimpleNamespace
from typing import Any

from fakes.naive_plan import NaiveDevice, Row, imply, plan_of

Order = tuple[float, bool]
"""When a server decided what it says now, and whether it had to accept the goal before."""

FIRST, LAST = (-inf, False), (inf, False)
"""Starts of jobs, and limits of time."""


class Named:
    """What references name values of."""

    values: Row

    def value(self, text: Any) -> Any:
        """Return what a reference stands for; any other value is itself.

        KeyError: it stands for nothing, or for no finite number (6.3).
        """
        result = self.values[text[2:-1]] if str(text).startswith('${') else text
        if isinstance(result, float) and not isfinite(result):
            raise KeyError(text)
        return result


@dataclass(eq=False)
class Job(Named):
    """A work order; `left`: source cycles that have not begun; `first`: its initialization."""

    id: str
    plan: SimpleNamespace
    left: int
    first: dict[str, Task] = field(default_factory=dict)
    items: list[Item] = field(default_factory=list)
    aborting: bool = False
    terms: tuple[int, float | None] = (0, None)
    """Priority and start."""
    rank: tuple[int, float] | None = (0, inf)
    """The smaller the more urgent; None: a person gave it its place (6.7)."""
    early: bool = False
    """It waits for its start (6.7)."""
    waits: int = 0
    """How often it was told to."""
    by_recipe: bool = False
    values: Row = field(default_factory=dict)
    """What references of its initialization stand for."""
    held: bool = False
    paused: bool = False
    asks: bool = False
    """The next item is its first piece (6.12)."""
    piece: Any = None
    """The first piece whose approval it waits for (6.12)."""
    stopping: bool = False
    needs: set[str] = field(default_factory=set)
    """The components of all of its tasks, and the conveyor (7.5)."""


@dataclass(eq=False)
class Item(Named):
    """What a source cycle makes, or an empty position."""

    job: Job
    id: str
    values: Row
    """What references to it stand for (6.3)."""
    place: int
    """A section, before it is placed too; 0: it has left the belt."""
    placed: bool = False
    empty: bool = False
    rejected: bool = False
    serial: str = ''

    def remember(self, task: Task, results: Row) -> None:
        self.values |= {f'results.{task.id}.{name}': value for name, value in results.items()}

    def forget(self, task: Task) -> None:
        given = f'results.{task.id}.'
        self.values = {name: v for name, v in self.values.items() if not name.startswith(given)}

    def at(self, section: int) -> Row:
        return {'job': self.job, 'section': section, 'item': self}


@dataclass(eq=False)
class Task:
    """A task of an item, of a job's initialization (no item), or the belt's move (no job).

    It is `new`, `running`, `failed`, `held`, `waiting` for a further attempt, or `done`.
    """

    id: str
    given: Row
    device: NaiveDevice
    needs: set[str]
    """Its component and zones."""
    job: Any = None
    section: int | None = None
    item: Any = None
    after: list[Task] = field(default_factory=list)
    state: str = 'new'
    attempt: int = 0
    not_before: float = 0.0
    reason: str = ''
    refused: Row = field(default_factory=dict)
    """Results that its verdict refused (2.8)."""
    cancelled: str = ''
    awaited_until: float = 0.0
    """How long its end is awaited after it was cancelled (2.4)."""
    deaf_from: float = 0.0
    """The time from which its server hears no cancel."""
    asked: tuple[int, int] | None = None
    """The attempt, and its round, that has waited for its setup to be told (5.3.9)."""
    told_by: float = 0.0
    """The end of that wait."""
    repeat: Any = None
    """Its tasks, further rounds begun, and how many there may be (3.9)."""
    goals: int = 0
    """Sent in all, whatever the round."""
    sent: tuple[int, int] = (-1, 0)
    """Before which delivery its last goal was sent, and the place of that goal among others."""
    busy: bool = False
    """Whether it has its component and zones: it runs, is held, or was, and is to be tried again
    (2.5, 4.4)."""

    @property
    def round(self) -> int:
        return self.repeat.begun if self.repeat else 0

    @property
    def waits_for(self) -> set[int]:
        """The sections that it waits for, itself or through dependencies (5.2)."""
        return set(self.device.places).union(*(task.waits_for for task in self.after))

    @property
    def does(self) -> tuple[str, str]:
        """What is the same task for `once`, with whatever arguments (5.1)."""
        return self.given['action'], self.given['task']

    @property
    def args(self) -> Row:
        given, of = self.given.get('args', {}), self.item or self.job
        return {key: of.value(v) if of else v for key, v in given.items()}

    @property
    def where(self) -> Row:
        return {'job': self.job, 'section': self.section, 'item': self.item, 'task': self}


class NaiveRun(ABC):
    """The state of a cell, the time, and the records; all but the rules."""

    def __init__(
        self, cell: Row, scripts: Sequence[Row], duration: Callable[[str, int], float | None]
    ) -> None:
        self.sections = range(1, cell['conveyor']['sections'] + 1)
        parts = {**cell['components'], 'conveyor': cell['conveyor']}.items()
        devices = [NaiveDevice(name, given, self.sections, duration) for name, given in parts]
        self.devices = {device.given['action']: device for device in devices}
        self.plans = {script['script']: plan_of(script) for script in scripts}
        for plan in self.plans.values():
            imply(plan, self.devices)
        self.now, self.beat, self.moving, self.state = 0.0, 1, False, 'Stopped'
        self.stopped_by_hand = False
        """An operator's stop, until an operator's start (7.2)."""
        self.stop_after = ''
        """`item` or `job`: the line runs empty (6.6)."""
        self.had_work = False
        """Since it was started: one that never had an order waits for one (7.2)."""
        self.move = Task('index', cell['conveyor'], devices[-1], {'conveyor'})
        self.jobs: list[Job] = []
        self.cycles: dict[int, Any] = {}
        """Those that are not complete, by their sections."""
        self.last_beat = dict.fromkeys(self.sections, 0)
        """Of each section's last cycle that has begun."""
        self.flags: dict[str, int] = {}
        self.out: list[str] = []
        """Components out of service (7.5)."""
        has_to_be = cell.get('release') != 'automatic'
        self.generated = {row['script'] for row in scripts if has_to_be and 'made_from' in row}
        """Names of scripts that nobody has released yet (6.10)."""
        self.started: list[Task] = []
        """Those that are not done, the one started last at the end."""
        self.done: dict[tuple[str, str], Row] = {}
        """The arguments of tasks whose last attempt succeeded (5.1)."""
        self.setups: dict[tuple[str, str], str] = {}
        """The known values, by component and setup (5.3)."""
        self.topics: dict[tuple[str, str], str] = {}
        """What state topics tell of the others (5.3.9)."""
        self.line_knows: dict[tuple[str, str], tuple[str, bool]] = {}
        """What the line has changed or was told last, and whether it was told (5.3.9)."""
        self.serials: set[str] = set()
        """Of all items that ever had one (6.8)."""
        self.limit = cell.get('hold_after')
        self.approves = cell.get('first_piece') != 'automatic'
        """Whether first pieces have to be approved (6.12)."""
        self.counts: dict[str, SimpleNamespace] = {}
        """Items in the order in which they were begun, by the script that has a limit (7.7)."""
        self.holds: list[Any] = []
        self.records: list[Row] = []
        self._facts: set[tuple[Any, ...]] = set()
        self._agenda: list[tuple[float, Order, Any, Any, int, str]] = []
        self.deliveries = 0
        """Goals that were sent since the last one are on their way."""
        self.numbers, self._hold_ids = itertools.count(), itertools.count(1)

    def say(self, event: str, where: Row, **fields: Any) -> None:
        """Record an event; jobs, items, tasks and holds are named by their ids."""
        self._facts.add((event, *where.values()))
        row = {'time': round(self.now, 6), 'event': event, **where, **fields}
        named = {key: getattr(value, 'id', value) for key, value in row.items()}
        if named.get('results'):
            named['results'] = {key: _written(value) for key, value in named['results'].items()}
        self.records.append({key: value for key, value in named.items() if value is not None})

    def said(self, event: str, where: Row) -> bool:
        return (event, *where.values()) in self._facts

    def say_once(self, event: str, where: Row) -> None:
        if not self.said(event, where):
            self.say(event, where)

    def slots(self) -> dict[int, Item]:
        items = [item for job in self.jobs for item in job.items if item.placed and item.place]
        return {item.place: item for item in sorted(items, key=lambda item: item.place)}

    def new_job(self, id_: str, script: str, quantity: int) -> Job:
        job = Job(id_, self.plans[script], quantity, values={'order.id': id_})
        job.asks = job.plan.asks
        job.first = {given['id']: self.new_task(given, job) for given in job.plan.first}
        tasks = [t for steps in job.plan.lists.values() for step in steps for m in step for t in m]
        given = [task['action'] for task in [*tasks, *job.plan.first]]
        job.needs = {'conveyor', *(self.devices[action].name for action in given)}
        for link in job.plan.order:
            job.first[link['downstream']].after.append(job.first[link['upstream']])
        return job

    def new_item(self, job: Job) -> Item:
        number = len(job.items) + 1
        values = {'item.number': number, **job.values}
        item = Item(job, f'{job.id}/{number}', values, job.plan.source)
        job.items.append(item)
        job.left -= 1
        if self.limit or job.plan.limit:
            self.count_of(job).items.append(item)
        return item

    def count_of(self, job: Job) -> SimpleNamespace:
        """Return what is counted together with the items of a job (7.7)."""
        new = SimpleNamespace(items=[], rejects=[], hold=None)
        return self.counts.setdefault(job.plan.name if job.plan.limit else '', new)

    def new_cycle(self, number: int, item: Item, beat: int) -> SimpleNamespace:
        steps = [
            [[self.new_task(task, item.job, number, item) for task in member] for member in step]
            for step in item.job.plan.lists[number]
        ]
        for tasks in [tasks for step in steps for tasks in step]:
            times = item.job.plan.repeats.get(tasks[0].id)
            repeat = SimpleNamespace(tasks=tasks, begun=0, times=times) if times else None
            for task in tasks:
                task.repeat = repeat
        return SimpleNamespace(item=item, where=item.at(number), beat=beat, steps=steps)

    def new_task(self, given: Row, job: Job, section: int | None = None, item: Any = None) -> Task:
        device = self.devices[given['action']]
        zones = {f'zone {zone}' for zone, ids in job.plan.zones.items() if given['id'] in ids}
        return Task(given['id'], given, device, {device.name} | zones, job, section, item)

    def hold(
        self,
        reason: str,
        where: Row,
        answers: list[str],
        task: Task | None = None,
        items: list[str] | None = None,
    ) -> None:
        hold = SimpleNamespace(id=str(next(self._hold_ids)), reason=reason, where=where)
        hold.answers, hold.task = answers, task
        self.holds.append(hold)
        facts: Row = {}
        if task:
            action, name = task.does
            facts = {'name': name, 'action': action, 'component': task.device.name}
            facts |= {'attempt': task.attempt, 'attempts': task.given.get('retries', 0) + 1}
            facts['round'] = task.round or None
        self.say(
            'hold.raised', where, hold=hold, **facts, reason=reason, answers=answers, items=items
        )

    def lacks(self, job: Job) -> list[str]:
        """Return what is out of service and needed by a job of the queue (7.5)."""
        return [name for name in self.out if name in job.needs and not self.has_begun(job)]

    def is_unreleased(self, job: Job) -> bool:
        """Tell whether a job of the queue waits until its script is released (6.10)."""
        return job.plan.name in self.generated and not self.has_begun(job)

    def has_begun(self, job: Job) -> bool:
        return self.said('job.started', {'job': job})

    def is_able(self, job: Job) -> bool:
        """Tell whether nothing that it waits for lets others pass a job."""
        return not (job.held or job.early or self.lacks(job) or self.is_unreleased(job))

    def able(self) -> list[Job]:
        return [job for job in self.jobs if self.is_able(job)]

    def at(self, after: float, task: Any, end: str, order: Order, number: Any = None) -> None:
        """Note how an attempt ends after a while, or the wait of a job.

        :param order: its place at that time
        :param number: its place among those of the same order; None: the last one; jobs: their ids
        """
        time, number = round(self.now + after, 6), next(self.numbers) if number is None else number
        self._agenda.append((time, order, number, task, getattr(task, 'goals', 0), end))

    def advance(self, until: float) -> None:
        """Let everything happen up to a time, which is rounded as the agenda is: ties are ties."""
        until = round(until, 6)
        self.settle()
        while self.jobs and self._agenda and min(self._agenda)[0] <= until:
            self.now, self.deliveries = min(self._agenda)[0], self.deliveries + 1
            due = sorted(note for note in self._agenda if note[0] == self.now)
            self._agenda = [note for note in self._agenda if note[0] > self.now]
            for _, _, _, task, goals, end in due:
                if isinstance(task, Job) and task.early and end == f'start {task.waits}':
                    task.early = False
                    self.had_work |= self.is_able(task)
                    self.say('job.may_start', {'job': task})
                elif isinstance(task, Task) and (task.state, task.goals) == ('running', goals):
                    self.end(task, end)
            self.settle()
        self.now = max(self.now, until) if self.jobs else self.now
        self.deliveries += 1

    @abstractmethod
    def settle(self) -> None: ...

    @abstractmethod
    def end(self, task: Task, end: str) -> None: ...


def _written(value: Any) -> Any:
    """Return a value as records have it; JSON has no NaN."""
    return {'$float': 'nan'} if isinstance(value, float) and isnan(value) else value
