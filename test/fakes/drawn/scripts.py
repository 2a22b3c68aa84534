"""Scripts: valid ones, of which `check` may refuse nothing but a deadlock."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from fakes.drawn.cells import draw_limit
from fakes.drawn.conditions import draw_comparison, draw_condition, draw_verdict
from fakes.drawn.links import draw_flags, draw_initialization, draw_zones
from fakes.drawn.plan import Draw, Row, Traits, chance, tasks_of
from hypothesis import strategies as st

POLICIES = ('hold', 'continue', 'reject', 'abort_job')


class DrawnScript:
    """Draws one script: first the places of its tasks, then what follows from them."""

    def __init__(self, draw: Draw, name: str, size: int, cell: Row, traits: Traits) -> None:
        self.draw, self.name, self.size, self.cell, self.traits = draw, name, size, cell, traits
        self.source = min(size, 1 + chance(draw, 15))
        self.sink = max(self.source, size - chance(draw, 15))
        self.lists: dict[int, list[Any]] = {}
        self.early: set[int] = set()
        self.tasks: list[tuple[int, Row]] = []
        """All tasks of the lists with their sections, in the order of the lists."""
        self.repeated: set[str] = set()
        """Tasks in repeats, which no flag may name."""
        self.policies = ('reject', *POLICIES[1:3]) if traits.rejects else POLICIES
        self.tools = {name: draw(st.sampled_from('xy')) for name in with_tools(cell)}
        """The value that each component with a setup needs in this script."""
        self.readable: list[str] = []
        """Tasks whose results later ones may use."""

    def whole(self) -> Row:
        """Return the script."""
        for number in range(self.source, self.sink + 1):
            if number in (self.source, self.sink) or chance(self.draw, 85):
                self._section(number)
        self._ways_out()
        script: Row = {'script': self.name, **draw_initialization(self.draw, self.cell)}
        script['sections'] = {
            n: {'release_conveyor': 'after_last_conveyor_task', 'tasks': steps}
            if n in self.early
            else steps
            for n, steps in sorted(self.lists.items())
        }
        if chance(self.draw, 30):
            script['made_from'] = {'recipe': 'R', 'version': 3}
        if self.traits.pieces and chance(self.draw, 85):
            script['first_piece'] = True
        if self.traits.rejects and chance(self.draw, 40):
            script['hold_after'] = draw_limit(self.draw)
        if chance(self.draw, 20):
            script['lots'] = {'box': '${order.id}'}
        once = [placed for placed in self.tasks if placed[1]['id'] not in self.repeated]
        script['lateral_dependencies'] = draw_flags(self.draw, self.name, once)
        if self.traits.shared:
            first = script.get('initialization', [])
            script['zones'] = draw_zones(self.draw, self.tasks, first)
        return {key: value for key, value in script.items() if value}

    # --- lists ---

    def _section(self, number: int) -> None:
        least = 0 if number in (self.source, self.sink) else 1
        early = chance(self.draw, 25)
        steps: list[Any] = [
            self._group(number) if chance(self.draw, 20) else self._alone(number)
            for _ in range(self.draw(st.integers(least, 3)))
        ]
        if number == self.source:
            place = self._task(number, 'a', requires_conveyor=True, qty_change=1)
            for key in ('when', 'unless', 'runs_for'):
                place.pop(key, None)
            steps.insert(self.draw(st.integers(0, len(steps))), place)
        if self.cell['components'].get('reader', {}).get('section') == number:
            steps.insert(self.draw(st.integers(0, len(steps))), self._scan(number))
        self.lists[number] = steps
        if early and any(self._needs_belt(step) for step in steps) and number != self.sink:
            self.early.add(number)
        self._settle(number)

    def _single(self, number: int) -> Row:
        task = self._task(number, self.draw(st.sampled_from(self._devices(number))))
        name = task['action'].split('/')[1]
        if name in self.tools and self.draw(st.integers(0, 3)) == 0:
            for key in ('when', 'unless', 'fails_unless', 'setup'):
                task.pop(key, None)
            given = {'special_argument_1': self.tools[name]}
            task |= {'task': 'TASK_C', 'args': given, 'runs_for': 'all'}
        return task

    def _alone(self, number: int) -> Row:
        if not chance(self.draw, 15):
            return self._single(number)
        return self._repeat(number, self._devices(number))

    def _repeat(self, number: int, devices: Sequence[str]) -> Row:
        draw, before = self.draw, list(self.readable)
        tasks = []
        for _ in range(draw(st.integers(1, 3))):
            tasks.append(self._task(number, draw(st.sampled_from(devices))))
            if tasks[-1].get('runs_for', 'good') != 'rejected':
                self.readable.append(tasks[-1]['id'])
        last = tasks[-1]
        last.setdefault('fails_unless', draw_verdict(draw, last['id'], before))
        self.readable = before
        self.repeated |= {task['id'] for task in tasks}
        return {'repeat': tasks, 'times': draw(st.integers(1, 2))}

    def _group(self, number: int) -> Row:
        devices = self._devices(number)
        members: list[Any] = []
        for device in devices[: self.draw(st.integers(2, 3))]:
            length = self.draw(st.integers(1, 2))
            if chance(self.draw, 15):
                members.append(self._repeat(number, [device]))
                continue
            tasks = [self._task(number, device) for _ in range(length)]
            members.append(tasks[0] if length == 1 else tasks)
        return {'parallel': members}

    def _devices(self, number: int) -> list[str]:
        names = ['a', 'b']
        for name, component in self.cell['components'].items():
            place = component.get('section', [])
            if isinstance(place, list) and (not place or number in place):
                names.append(name)
        return names

    def _task(self, number: int, device: str, **fixed: Any) -> Row:
        draw = self.draw
        name = f'{device}{number}' if device in ('a', 'b') else device
        count = sum(1 for task in _ids(self.lists) if task) + len(self.tasks)
        task: Row = {
            'id': f't{number}_{count}',
            'task': draw(st.sampled_from(('TASK_A', 'TASK_B'))),
        }
        task |= {'action': f'/{name}/do', 'on_failure': draw(st.sampled_from(self.policies))}
        task['timeout'] = 8.03
        if name in self.tools and not chance(draw, 30):
            task['setup'] = {'tool': self.tools[name]}
        if chance(draw, 35):
            task['requires_conveyor'] = False
        if chance(draw, 25):
            task['retries'] = draw(st.integers(1, 2))
            task['retry_delay'] = draw(st.sampled_from((0.0, 1.57)))
        if chance(draw, 15):
            task['runs_for'] = draw(st.sampled_from(('rejected', 'all')))
        if chance(draw, 20):
            task['repeatable'] = True
        self._condition(task)
        if chance(draw, 15) and 'qty_change' not in fixed:
            task['fails_unless'] = draw_verdict(draw, task['id'], self.readable)
        task |= fixed
        self.tasks.append((number, task))
        return task

    def _scan(self, number: int) -> Row:
        task: Row = {'id': 'scan', 'task': 'READ', 'action': '/reader/do', 'identifies': 'serial'}
        task |= {'on_failure': self.draw(st.sampled_from(POLICIES)), 'timeout': 8.03}
        task['retries'] = self.draw(st.integers(0, 1))
        self.tasks.append((number, task))
        return task

    def _condition(self, task: Row) -> None:
        draw = self.draw
        if not chance(draw, 25):
            return
        key = draw(st.sampled_from(('when', 'unless')))
        if self.readable and task.get('runs_for') != 'rejected' and chance(draw, 60):
            read = draw(st.sampled_from(self.readable))
            if chance(draw, 30):
                task['args'] = {'special_argument_2': f'${{results.{read}.measurement}}'}
            else:
                task[key] = draw_condition(draw, read)
        else:
            task[key] = draw_comparison(draw, '${item.number}')

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
            is_scan = 'identifies' in task
            if not is_scan and task not in trailing and task.get('runs_for') != 'rejected':
                self.readable.append(task['id'])

    def _ways_out(self) -> None:
        """Let every item meet exactly one task that takes it out (3.2)."""
        draw, steps = self.draw, self.lists[self.sink]
        tail = [t for t in steps if 'id' in t and t.get('qty_change', 0) == 0]
        trail = []
        if tail and steps[-1] is tail[-1] and chance(draw, 40):
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


def with_tools(cell: Row) -> list[str]:
    """Return the components that have a setup."""
    return [name for name, component in cell['components'].items() if 'setups' in component]


def _ids(lists: dict[int, list[Any]]) -> list[str]:
    return [task['id'] for steps in lists.values() for task in tasks_of(steps)]
