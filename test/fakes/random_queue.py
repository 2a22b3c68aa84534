"""Random commands to the queue of a random line, while its jobs run."""

from __future__ import annotations

from random import Random

from fakes.random_line import RandomLine
from fakes.virtual_run import BY, VirtualRun

from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.job_commands import AddJobs, MoveJob, RunNext, StopAfter, UpdateJob
from bt_orchestrator.model.order import Job
from bt_orchestrator.runtime.job_queue import CONTROLS

KINDS = ('add', 'add', 'move', 'next', 'update', 'control', 'control', 'stop')


class QueueOperator:
    """Asks for one thing after the other, of jobs that may or may not be there."""

    def __init__(self, line: RandomLine, seed: int) -> None:
        self._random = Random(seed)
        self._scripts = [line.line.script(t, f'script_{n}') for n, t in enumerate(line.texts)]
        self._given = 0
        self.accepted = 0

    def act(self, run: VirtualRun) -> None:
        """Give a few commands."""
        for _ in range(self._random.randint(1, 4)):
            self.accepted += self._act(run).accepted

    def let_everything_end(self, run: VirtualRun) -> None:
        """Take back whatever keeps jobs from ending; the cell starts for an order."""
        run.ask(StopAfter('never', BY))
        for name in list(run.state.jobs):
            run.control('resume', name)
            run.control('release', name)
        assert run.ask(AddJobs((self._job('last'),), BY)).accepted

    def _act(self, run: VirtualRun) -> Answer:
        random = self._random
        kind = random.choice(KINDS)
        if kind == 'add':
            return run.ask(self._add(len(run.state.queue)))
        if kind == 'stop':
            return run.ask(StopAfter(random.choice(('item', 'job', 'never', 'never')), BY))
        name = f'Q{random.randint(0, self._given)}'
        if kind == 'move':
            return run.ask(MoveJob(name, random.randint(1, 3), BY))
        if kind == 'next':
            return run.ask(RunNext(name, BY))
        if kind == 'update':
            return run.ask(UpdateJob(self._job(name), BY))
        return run.control(random.choice(list(CONTROLS)), name)

    def _add(self, queued: int) -> AddJobs:
        count = self._random.randint(1, 2)
        jobs = tuple(self._job(f'Q{self._given + n}') for n in range(count))
        self._given += count
        position = self._random.choice((None, None, 1, queued + 1))
        return AddJobs(jobs, BY, position, held=self._random.random() < 0.3)

    def _job(self, name: str) -> Job:
        return Job(name, self._random.choice(self._scripts), self._random.randint(1, 4), {})
