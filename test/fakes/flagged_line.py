"""Random lines whose flags nearly fit: about half of them get stuck.

Everything that moves a flag or the belt may appear: groups, steps that need no conveyor, early
release, sections without work, source and sink anywhere, flags in both directions.
"""

from __future__ import annotations

from functools import cache
from random import Random

from fakes.line import Line

from bt_orchestrator.model.script import Script

line_of = cache(Line)
"""A cell with so many sections."""


class FlaggedLine:
    """One line."""

    def __init__(self, seed: int, most_sections: int = 7) -> None:
        self._random = random = Random(seed)
        self.size = random.randint(2, most_sections)
        self.source = random.randint(1, self.size) if random.random() < 0.3 else 1
        self.sink = random.randint(self.source, self.size) if random.random() < 0.3 else self.size
        self.line = line_of(self.size)
        self._places: dict[str, int] = {}
        lists = [self._section(number) for number in range(self.source, self.sink + 1)]
        self.text = '\n'.join(['sections:', *lists, *self._flags()])
        self.script: Script = self.line.script(self.text)

    def _chance(self, of_one: float) -> bool:
        return self._random.random() < of_one

    # --- lists ------------------------------------------------------------------------------

    def _section(self, number: int) -> str:
        count = self._random.randint(0, 3)
        steps = [
            self._group(number) if self._chance(0.2) else self._single(number)
            for _ in range(count)
        ]
        placed = -1
        if number == self.source:
            placed = self._random.randint(0, len(steps))
            steps.insert(placed, self._task(number, 'place', 'qty_change: 1'))
        if number == self.sink:
            steps.insert(
                self._random.randint(placed + 1, len(steps)),
                self._task(number, 'pack', 'qty_change: -1'),
            )
        if not steps:
            return ''
        early = self._chance(0.5) and any(self._needs_belt(step) for step in steps)
        release = 'after_last_conveyor_task' if early else 'end_of_cycle'
        return f'  {number}: {{release_conveyor: {release}, tasks: [{", ".join(steps)}]}}'

    @staticmethod
    def _needs_belt(step: str) -> bool:
        return step.count('@') > step.count('requires_conveyor: false')

    def _group(self, number: int) -> str:
        tracks = [
            ', '.join(self._single(number, device) for _ in range(self._random.randint(1, 2)))
            for device in 'ab'
        ]
        return f'{{parallel: [[{tracks[0]}], [{tracks[1]}]]}}'

    def _single(self, number: int, device: str = '') -> str:
        free = self._chance(0.35)
        name = f't{number}_{len(self._places)}'
        return self._task(number, name, 'requires_conveyor: false' if free else '', device)

    def _task(self, number: int, name: str, option: str, device: str = '') -> str:
        self._places[name] = number
        device = device or self._random.choice('ab')
        return f'{{id: {name}, @{device}{number}{", " + option if option else ""}}}'

    # --- flags ------------------------------------------------------------------------------

    def _flags(self) -> list[str]:
        lines = []
        for number in range(self._random.randint(1, 4)):
            upstream, downstream = self._pair()
            ahead = self._places[downstream] - self._places[upstream]
            spare = self._random.choice([-1, 0, 0, 0, 0, 1])
            if ahead > 0:
                initial = self._random.choice([0, 0, 0, 1])
                capacity = max(1, ahead + initial + spare)
            else:
                initial = max(0, spare - ahead)
                capacity = max(1, initial + self._random.choice([0, 0, 1]))
            lines.append(
                f'  - {{flag: f{number}, upstream: {upstream}, downstream: {downstream}, '
                f'capacity: {capacity}, initial: {initial}}}'
            )
        return ['lateral_dependencies:', *lines]

    def _pair(self) -> tuple[str, str]:
        """Draw two tasks, seldom of one section."""
        for _ in range(9):
            upstream, downstream = self._random.sample(sorted(self._places), 2)
            if self._places[upstream] != self._places[downstream]:
                break
        return upstream, downstream


class SharingScripts:
    """Scripts of one line that share all their flags, but not the order in which they use them."""

    def __init__(self, seed: int, count: int = 3) -> None:
        self._random = random = Random(seed)
        self.size = random.randint(3, 6)
        self.line = line_of(self.size)
        places = sorted(random.sample(range(1, self.size + 1), min(self.size, 4)))
        self._flags = [self._flag(number, places) for number in range(random.randint(2, 4))]
        self.scripts = [self.line.script(self._script(), f's{number}') for number in range(count)]

    def _flag(self, number: int, places: list[int]) -> tuple[str, int, int, int, int]:
        """Draw a flag that only those may have who release the belt early."""
        random = self._random
        near, far = sorted(random.sample(places, 2))
        if random.random() < 0.8:
            return f'f{number}', near, far, max(1, far - near - random.randint(0, 1)), 0
        initial = max(0, far - near - random.randint(0, 1))
        return f'f{number}', far, near, max(1, initial + random.randint(0, 1)), initial

    def _script(self) -> str:
        random = self._random
        text = ['sections:']
        for number in range(1, self.size + 1):
            names = [f'u_{flag}' for flag, up, *_ in self._flags if up == number]
            names += [f'd_{flag}' for flag, _, down, *_ in self._flags if down == number]
            random.shuffle(names)
            first = random.randint(0, len(names) if random.random() < 0.5 else 0)
            ends = {1: ('place', 'qty_change: 1'), self.size: ('pack', 'qty_change: -1')}
            name, option = ends.get(number, (f'work{number}', 'timeout: none'))
            free = {task_id for task_id in names if random.random() < 0.75}
            tasks = [
                f'{{id: {task_id}, @{random.choice("ab")}{number}, '
                f'requires_conveyor: {"false" if task_id in free else "true"}}}'
                for task_id in names
            ]
            tasks.insert(first, f'{{id: {name}, @a{number}, {option}}}')
            release = random.choice(['end_of_cycle', *['after_last_conveyor_task'] * 5])
            text.append(
                f'  {number}: {{release_conveyor: {release}, tasks: [{", ".join(tasks)}]}}'
            )
        text.append('lateral_dependencies:')
        text += [
            f'  - {{flag: {flag}, upstream: u_{flag}, downstream: d_{flag}, '
            f'capacity: {capacity}, initial: {initial}}}'
            for flag, _, _, capacity, initial in self._flags
        ]
        return '\n'.join(text)
