"""Lines nobody wrote by hand: Hypothesis strategies for cells, scripts, orders, faults, operators.

Everything is built so that it is a valid line (nothing is drawn and thrown away): the only thing
that `check` may refuse is a deadlock. Files are plain data, as YAML would say them.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from hypothesis import strategies as st

Row = dict[str, Any]
Draw = st.DrawFn

TYPE = 'bt_orchestrator_interfaces/action/Component'
SECONDS = (1.0, 0.5, 2.5, 7.0, 0.0)
FAULTS = (
    'abort',
    'false',
    'reject',
    'cancel',
    'late:3.3',
    'hang',
    'die:1',
    'mute',
    'ignore_cancel',
)
POLICIES = ('hold', 'continue', 'reject', 'abort_job')
MOMENTS = (0.13, 3.71, 17.93, 61.57)
MOST_SECTIONS = 8


@dataclass(frozen=True)
class Moment:
    """What an operator does after a while, if there is something to do."""

    delay_s: float
    choice: int


@dataclass(frozen=True)
class Plan:
    """A cell with its work and its bad luck."""

    cell: Row
    scripts: tuple[Row, ...]
    orders: tuple[tuple[str, str, int], ...]
    """Order id, script, quantity."""
    moments: tuple[Moment, ...]
    seconds: tuple[float, ...]
    """Durations of the goals of each component in turn; empty: the nominal ones."""

    @property
    def has_faults(self) -> bool:
        devices = [self.cell['conveyor'], *self.cell['components'].values()]
        return any(device.get('faults') for device in devices)

    def without_faults(self) -> Plan:
        """Return the same line, in which nothing goes wrong."""
        cell = copy.deepcopy(self.cell)
        for device in [cell['conveyor'], *cell['components'].values()]:
            device['faults'] = []
        return replace(self, cell=cell)

    def duration(self, component: str, nth: int) -> float | None:
        """Return the seconds of a component's nth goal; None: nominal."""
        if not self.seconds:
            return None
        return self.seconds[(nth + sum(map(ord, component))) % len(self.seconds)]


@dataclass(frozen=True)
class Traits:
    """What the lines of a property may have."""

    shared: bool = True
    """Shared components and zones."""
    faults: bool = True
    tied: bool = True
    """Durations may be equal, so that several things happen at one moment."""
    most_sections: int = MOST_SECTIONS


@st.composite
def lines(draw: Draw, traits: Traits = Traits()) -> Plan:
    """Draw a line."""
    size = min(draw(st.integers(1, traits.most_sections)), draw(st.integers(2, MOST_SECTIONS)))
    cell = _cell(draw, size, traits)
    scripts = [_Script(draw, 'script_0', size, cell, traits).whole()]
    if draw(st.booleans()):
        scripts.append(_Script(draw, 'script_1', size, cell, traits).whole())
    if draw(st.integers(0, 3)) == 0:
        scripts.append(_variant(draw, scripts[0]))
    count = draw(st.integers(1, 4))
    chosen = [scripts[draw(st.integers(0, len(scripts) - 1))]['script'] for _ in range(count)]
    orders = tuple((f'J{n}', name, draw(st.integers(1, 4))) for n, name in enumerate(chosen))
    moment = st.builds(Moment, st.sampled_from(MOMENTS), st.integers(0, 11))
    moments = draw(st.lists(moment, max_size=8))
    drawn = draw(st.lists(st.sampled_from((*SECONDS, 40.0)), max_size=5)) if traits.tied else []
    return Plan(cell, tuple(scripts), orders, tuple(moments), tuple(drawn))


def _chance(draw: Draw, percent: int) -> bool:
    """Draw true so often; false is simpler."""
    return draw(st.integers(0, 99)) >= 100 - percent


# --- cells ----------------------------------------------------------------------------------


def _cell(draw: Draw, size: int, traits: Traits) -> Row:
    places: Row = {f'{letter}{n}': n for n in range(1, size + 1) for letter in 'ab'}
    if traits.shared and size > 1 and draw(st.booleans()):
        places['arm'] = sorted(draw(st.sets(st.integers(1, size), min_size=2, max_size=3)))
    if traits.shared:
        places['lamp'] = []
    components = {
        name: _component(draw, name, place, number, traits)
        for number, (name, place) in enumerate(places.items())
    }
    conveyor = {
        'sections': size,
        'action': '/belt/do',
        'type': 'bt_orchestrator_interfaces/action/Conveyor',
        'task': 'MOVE_ONE_INDEX',
        'duration': draw(st.sampled_from((2.0, 0.5, 10.0))) + (0.0 if traits.tied else 0.0137),
        'timeout': 60.01,
        'retries': draw(st.integers(0, 1)),
        'on_failure': draw(st.sampled_from(('hold', 'abort_job'))),
        'faults': _faults(draw, 6) if traits.faults else [],
    }
    return {'cell': 'random_cell', 'conveyor': conveyor, 'components': components}


def _component(draw: Draw, name: str, place: Any, number: int, traits: Traits) -> Row:
    found: Row = {'action': f'/{name}/do', 'type': TYPE}
    if place != []:
        found['section'] = place
    seconds = draw(st.sampled_from(SECONDS))
    if not traits.tied:
        seconds = 0.2 + seconds / 10 + number * 0.0171
    found['durations'] = dict.fromkeys(('PREPARE', 'TASK_A', 'TASK_B'), seconds)
    if _chance(draw, 20):
        found['results'] = {'TASK_A': {'item_present': False}}
    if traits.faults and (faults := _faults(draw, 15)):
        found['faults'] = faults
    return found


def _faults(draw: Draw, percent: int) -> list[str]:
    if not _chance(draw, percent):
        return []
    numbers = sorted(draw(st.sets(st.integers(1, 7), min_size=1, max_size=2)))
    return [f'#{n}={draw(st.sampled_from(FAULTS))}' for n in numbers]


# --- scripts --------------------------------------------------------------------------------


class _Script:
    """Draws one script: first the places of its tasks, then what follows from them."""

    def __init__(self, draw: Draw, name: str, size: int, cell: Row, traits: Traits) -> None:
        self.draw, self.name, self.size, self.cell, self.traits = draw, name, size, cell, traits
        self.source = min(size, 1 + _chance(draw, 15))
        self.sink = max(self.source, size - _chance(draw, 15))
        self.lists: dict[int, list[Any]] = {}
        self.early: set[int] = set()
        self.tasks: list[tuple[int, Row]] = []
        """All tasks of the lists with their sections, in the order of the lists."""
        self.readable: list[str] = []
        """Tasks whose results later ones may use."""

    def whole(self) -> Row:
        for number in range(self.source, self.sink + 1):
            if number in (self.source, self.sink) or _chance(self.draw, 85):
                self._section(number)
        self._ways_out()
        script: Row = {'script': self.name, 'initialization': self._initialization()}
        script['initialization_dependencies'] = self._order(script['initialization'])
        script['sections'] = {
            n: {'release_conveyor': 'after_last_conveyor_task', 'tasks': steps}
            if n in self.early
            else steps
            for n, steps in sorted(self.lists.items())
        }
        script['lateral_dependencies'] = self._flags()
        script['zones'] = self._zones(script['initialization']) if self.traits.shared else {}
        return {key: value for key, value in script.items() if value}

    # --- lists ---

    def _section(self, number: int) -> None:
        least = 0 if number in (self.source, self.sink) else 1
        early = _chance(self.draw, 25)
        steps: list[Any] = [
            self._group(number) if _chance(self.draw, 20) else self._single(number)
            for _ in range(self.draw(st.integers(least, 3)))
        ]
        if number == self.source:
            place = self._task(number, 'a', requires_conveyor=True, qty_change=1)
            for key in ('when', 'unless', 'runs_for'):
                place.pop(key, None)
            steps.insert(self.draw(st.integers(0, len(steps))), place)
        self.lists[number] = steps
        if early and any(self._needs_belt(step) for step in steps) and number != self.sink:
            self.early.add(number)
        self._settle(number)

    def _single(self, number: int) -> Row:
        return self._task(number, self.draw(st.sampled_from(self._devices(number))))

    def _group(self, number: int) -> Row:
        devices = self._devices(number)
        members: list[Any] = []
        for device in devices[: self.draw(st.integers(2, 3))]:
            length = self.draw(st.integers(1, 2))
            tasks = [self._task(number, device) for _ in range(length)]
            members.append(tasks[0] if length == 1 else tasks)
        return {'parallel': members}

    def _devices(self, number: int) -> list[str]:
        found = ['a', 'b']
        for name, component in self.cell['components'].items():
            place = component.get('section', [])
            if isinstance(place, list) and (not place or number in place):
                found.append(name)
        return found

    def _task(self, number: int, device: str, **fixed: Any) -> Row:
        draw = self.draw
        name = f'{device}{number}' if device in ('a', 'b') else device
        count = sum(1 for task in _ids(self.lists) if task) + len(self.tasks)
        task: Row = {
            'id': f't{number}_{count}',
            'task': draw(st.sampled_from(('TASK_A', 'TASK_B'))),
        }
        task |= {'action': f'/{name}/do', 'on_failure': draw(st.sampled_from(POLICIES))}
        task['timeout'] = 8.03
        if _chance(draw, 35):
            task['requires_conveyor'] = False
        if _chance(draw, 25):
            task['retries'] = draw(st.integers(1, 2))
            task['retry_delay'] = draw(st.sampled_from((0.0, 1.57)))
        if _chance(draw, 15):
            task['runs_for'] = draw(st.sampled_from(('rejected', 'all')))
        if _chance(draw, 20):
            task['repeatable'] = True
        self._condition(task)
        task |= fixed
        self.tasks.append((number, task))
        return task

    def _condition(self, task: Row) -> None:
        draw = self.draw
        if not _chance(draw, 25):
            return
        key = draw(st.sampled_from(('when', 'unless')))
        if self.readable and task.get('runs_for') != 'rejected' and _chance(draw, 60):
            read = draw(st.sampled_from(self.readable))
            if _chance(draw, 30):
                task['args'] = {'special_argument_2': f'${{results.{read}.measurement}}'}
            else:
                task[key] = f'${{results.{read}.item_present}}'
        else:
            task[key] = {'value': '${item.number}', 'equals': draw(st.integers(1, 3))}

    def _needs_belt(self, step: Row) -> bool:
        return any(task.get('requires_conveyor', True) for task in tasks_of([step]))

    def _settle(self, number: int) -> None:
        """Take back what a trailing task may not do; open results to later tasks (3.8, 6.3)."""
        steps = self.lists[number]
        trailing: list[Row] = []
        if number in self.early:
            last = max(n for n, step in enumerate(steps) if self._needs_belt(step))
            trailing = tasks_of(steps[last + 1 :])
        for task in tasks_of(steps):
            if task in trailing and task['on_failure'] == 'reject':
                task['on_failure'] = 'continue'
            if task not in trailing and task.get('runs_for', 'good') != 'rejected':
                self.readable.append(task['id'])

    def _ways_out(self) -> None:
        """Let every item meet exactly one task that takes it out (3.2)."""
        draw, steps = self.draw, self.lists[self.sink]
        tail = [t for t in steps if 'parallel' not in t and t.get('qty_change', 0) == 0]
        trail = []
        if tail and steps[-1] is tail[-1] and _chance(draw, 40):
            trail = [steps.pop()]
            trail[0]['on_failure'] = 'continue' if trail[0]['on_failure'] == 'reject' else 'hold'
        way = draw(st.sampled_from(('all', 'twins', 'early')))
        policies = st.sampled_from(('hold', 'abort_job'))
        inner = [n for n in self.lists if self.source < n < self.sink]
        if way == 'early' and not inner:
            way = 'twins'
        packs = [{'id': 'pack', 'runs_for': 'all' if way == 'all' else 'good'}]
        if way == 'twins':
            packs.append({'id': 'unpack', 'runs_for': 'rejected'})
        for pack in packs:
            steps.append(self._way_out(self.sink, pack, draw(policies)))
        if way == 'early':
            self._early_way_out(draw(st.sampled_from(inner)), draw(policies))
        steps.extend(trail)
        if trail and not trail[0].get('requires_conveyor', True) and draw(st.booleans()):
            self.early.add(self.sink)

    def _way_out(self, number: int, pack: Row, policy: str) -> Row:
        task = {'task': 'TASK_A', 'action': f'/a{number}/do', 'qty_change': -1, 'timeout': 8.03}
        whole = {**pack, **task, 'on_failure': policy}
        self.tasks.append((number, whole))
        return whole

    def _early_way_out(self, number: int, policy: str) -> None:
        """Take rejected items out before the sink; nothing may reject behind it."""
        out = self._way_out(number, {'id': 'out', 'runs_for': 'rejected'}, policy)
        self.early.discard(number)
        self.lists[number].append(out)
        for place, steps in self.lists.items():
            for task in tasks_of(steps) if place > number else []:
                if task['on_failure'] == 'reject':
                    task['on_failure'] = 'continue'

    # --- the rest ---

    def _initialization(self) -> list[Row]:
        draw = self.draw
        if draw(st.booleans()):
            return []
        names = sorted(self.cell['components'])
        chosen = draw(st.lists(st.sampled_from(names), max_size=3))
        tasks: list[Row] = [{'id': 'home', 'task': 'HOME', 'action': '/belt/do', 'once': True}]
        tasks = tasks if draw(st.booleans()) else []
        for number, name in enumerate(chosen):
            task: Row = {'id': f'p{number}', 'task': 'PREPARE', 'action': f'/{name}/do'}
            task['on_failure'] = draw(st.sampled_from(('hold', 'continue', 'abort_job')))
            task['timeout'] = 8.03
            if _chance(draw, 30):
                task['retries'] = 1
            if _chance(draw, 30):
                task['once'] = True
            tasks.append(task)
        return tasks

    def _order(self, tasks: list[Row]) -> list[Row]:
        ids = [task['id'] for task in tasks]
        pairs = [(ids[n - 1], ids[n]) for n in range(1, len(ids)) if _chance(self.draw, 40)]
        return [{'upstream': up, 'downstream': down} for up, down in pairs]

    def _flags(self) -> list[Row]:
        draw = self.draw
        pairs = self._pairs()
        count = draw(st.integers(0, 3)) if pairs else 0
        found = []
        for number in range(count):
            first, second = draw(st.sampled_from(pairs))
            capacity = draw(st.integers(1, 3))
            initial = draw(st.integers(0, capacity))
            if _chance(draw, 75):
                capacity, initial = self._fitting(first, second, capacity)
            ids = {
                'upstream': self.tasks[first][1]['id'],
                'downstream': self.tasks[second][1]['id'],
            }
            name = f'{self.name}_f{number}'
            found.append({'flag': name, **ids, 'capacity': capacity, 'initial': initial})
        return found

    def _pairs(self) -> list[tuple[int, int]]:
        """Return tasks of sections so near that a capacity of 3 is enough."""
        places = [place for place, _ in self.tasks]
        numbers = range(len(places))
        return [
            (u, d) for u in numbers for d in numbers if u != d and abs(places[u] - places[d]) <= 3
        ]

    def _fitting(self, first: int, second: int, capacity: int) -> tuple[int, int]:
        """Return counts with which a flag between two sections cannot close a circle alone."""
        distance = self.tasks[second][0] - self.tasks[first][0]
        if distance > 0:
            return max(distance, capacity), self.draw(st.integers(0, max(0, capacity - distance)))
        least = max(1, -distance)
        return max(capacity, least), least

    def _zones(self, initialization: Sequence[Row]) -> Row:
        draw = self.draw
        ids = [task['id'] for _, task in self.tasks] + [task['id'] for task in initialization]
        if len(ids) < 2 or not _chance(draw, 40):
            return {}
        names = ('table', 'door')[: draw(st.integers(1, 2))]
        members = st.sets(st.sampled_from(ids), min_size=2, max_size=3)
        return {name: sorted(draw(members)) for name in names}


def _variant(draw: Draw, script: Row) -> Row:
    """Return a script of another name that shares the flags of one, and moves at other times."""
    found = copy.deepcopy(script)
    found['script'] = 'script_2'
    for listed in found['sections'].values():
        if isinstance(listed, dict) and draw(st.booleans()):
            listed['release_conveyor'] = 'end_of_cycle'
        for task in tasks_of(listed['tasks'] if isinstance(listed, dict) else listed):
            if task.get('qty_change', 0) == 0 and _chance(draw, 30):
                task.pop('when', None)
                task['retries'] = 1
    return found


def tasks_of(steps: Sequence[Any]) -> list[Row]:
    """Return the tasks of steps, those of groups and their lists too."""
    found: list[Row] = []
    for step in steps:
        members = step.get('parallel', [step])
        for member in members:
            found += member if isinstance(member, list) else [member]
    return found


def _ids(lists: dict[int, list[Any]]) -> list[str]:
    return [task['id'] for steps in lists.values() for task in tasks_of(steps)]
