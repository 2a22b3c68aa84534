"""Random lines and operators, from a seed: whatever the script and the faults, the rules hold."""

from __future__ import annotations

from random import Random

from fakes.line import Line
from fakes.virtual_run import VirtualRun

FAULTS = ('abort', 'false', 'reject', 'cancel', 'hang', 'ignore_cancel', 'die:1', 'late:3', 'mute')
POLICIES = ('', 'on_failure: continue', 'on_failure: reject', 'on_failure: abort_job')


class RandomLine:
    """One cell, its jobs, and what its operator will do."""

    def __init__(self, seed: int) -> None:
        self._random = random = Random(seed)
        self.sections = random.randint(2, 5)
        names = [f'{letter}{n}' for n in range(1, self.sections + 1) for letter in 'ab']
        names += ['arm'] if self.sections > 2 else []
        seconds = {name: random.choice((0.5, 1.0, 2.0, 5.0)) for name in names}
        faults = {
            name: ' '.join(
                f'#{random.randint(1, 9)}={random.choice(FAULTS)}'
                for _ in range(random.randint(0, 2))
            )
            for name in (*names, 'conveyor')
        }
        self.line = Line(self.sections, seconds=seconds, faults=faults)
        self.texts = [self._script() for _ in range(random.randint(1, 3))]
        self.quantities = [random.randint(1, 5) for _ in self.texts]

    def run(self, *, rebuild: bool = False, viewed: bool = False, seed: int = 0) -> VirtualRun:
        """Run all jobs, answering every hold, until they ended."""
        operator = Random(seed)
        run = VirtualRun(self.line.cell, self.line.types, rebuild=rebuild, viewed=viewed)
        for number, text in enumerate(self.texts):
            script = self.line.script(text, f'script_{number}')
            assert run.submit(f'J{number}', script, self.quantities[number]).accepted
        run.go(until=operator.uniform(0, 60))
        for _ in range(400):
            if run.ended:
                break
            self.operate(run, operator)
            due = run.sim.clock.next_deadline() or run.now
            run.go(until=due + operator.uniform(0, 60))
        return run

    @staticmethod
    def operate(run: VirtualRun, operator: Random) -> None:
        """Answer some holds, and take an item off the belt now and then."""
        standing = [s.slot for s in run.state.sections.values() if s.slot is not None]
        for hold in list(run.state.holds.values()):
            if hold.reason == 'overrun':
                assert hold.item is not None
                assert run.remove(hold.item).accepted
            elif operator.random() < 0.7 and hold.id in run.state.holds:
                assert run.answer(operator.choice(hold.answers), hold.id).accepted
        if standing and operator.random() < 0.1:
            run.remove(operator.choice(standing))

    # --- scripts ----------------------------------------------------------------------------

    def _script(self) -> str:
        random, sections = self._random, self.sections
        lines = []
        if random.random() < 0.5:
            lines += ['initialization:', '  - {id: ready, @lamp, once: true}']
            lines += [f'  - {{id: p{n}, @a{n}.PREPARE}}' for n in (1, sections)]
        lines.append('sections:')
        middle: list[str] = []
        for n in range(1, sections + 1):
            tasks = self._tasks(n, middle)
            lines += [f'  {n}:', *(f'    - {task}' for task in tasks)] if tasks else []
        return '\n'.join([*lines, *self._flags(middle)])

    def _tasks(self, n: int, middle: list[str]) -> list[str]:
        random = self._random
        if n == self.sections:
            tasks = [f'{{id: pack, @a{n}, qty_change: -1, runs_for: all}}']
            return ['{id: check, @b' + str(n) + '}', *tasks] if random.random() < 0.5 else tasks
        numbers = range(random.randint(0, 3))
        found = [self._task(n, f's{n}_{number}', middle) for number in numbers]
        if n == 1:
            policy = random.choice(('', ', on_failure: continue'))
            found.insert(0, f'{{id: place, @a1, qty_change: 1{policy}}}')
        return found

    def _task(self, n: int, name: str, middle: list[str]) -> str:
        random = self._random
        middle.append(name)
        owners = [f'a{n}', f'b{n}', *(['arm'] if n in (2, 3) and self.sections > 2 else [])]
        options = [f'id: {name}', f'@{random.choice(owners)}', random.choice(POLICIES)]
        options.append(random.choice(('', 'retries: 1', 'retries: 2, retry_delay: 1.5')))
        options.append('timeout: 8')
        if random.random() < 0.3:
            options.append('requires_conveyor: false')
        if random.random() < 0.2:
            options.append('when: {value: "${item.number}", equals: 1}')
        if random.random() < 0.2:
            options.append('repeatable: true')
        return '{' + ', '.join(option for option in options if option) + '}'

    def _flags(self, middle: list[str]) -> list[str]:
        random = self._random
        lines = []
        if len(middle) > 1 and random.random() < 0.5:
            first, second = sorted(random.sample(range(len(middle)), 2))
            # With room for every item between the two the line cannot stick.
            lines.append('lateral_dependencies:')
            lines.append(
                f'  - {{flag: {middle[first]}_{middle[second]}, upstream: {middle[first]},'
                f' downstream: {middle[second]}, capacity: {self.sections + 1}}}'
            )
        if len(middle) > 1 and random.random() < 0.5:
            zone = random.sample(middle, 2)
            lines += ['zones:', f'  table: [{", ".join(zone)}]']
        return lines
