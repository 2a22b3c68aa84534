"""Operators who ask for one thing after the other, of jobs and of the cell, while jobs run."""

from __future__ import annotations

from collections.abc import Sequence
from random import Random

from fakes.commands import (
    Abort,
    Arrange,
    Clear,
    MoveJob,
    Reset,
    Resume,
    RunNext,
    Start,
    Stop,
    StopAfter,
)
from fakes.virtual_run import BY, VirtualRun, defaults

from bt_orchestrator.engine.runtime.job_queue import CONTROLS
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.jobs.job_commands import AddJobs, RequeueJob, UpdateJob
from bt_orchestrator.model.jobs.order import Job, RecipeChoice, Terms
from bt_orchestrator.model.judging.belt_statement import believed, parse_slots
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.state.proposed import queue_digest

KINDS = (
    *('add', 'add', 'move', 'next', 'update', 'control', 'control', 'stop', 'cell', 'service'),
    *('script', 'requeue', 'requeue', 'arrange'),
)
BY_RECIPE = RecipeChoice(('R-1',))
CELL = (Reset, Start, Stop, Abort, Resume)


class QueueOperator:
    """Gives commands that may or may not fit; chance decides."""

    def __init__(self, scripts: Sequence[Script], chance: Random) -> None:
        self._scripts, self._chance = scripts, chance
        self._given = 0
        self.accepted = 0

    def act(self, run: VirtualRun) -> None:
        """Give a few commands, and answer some holds."""
        for _ in range(self._chance.randint(1, 4)):
            self.accepted += self._act(run).accepted
        self.answer(run, 0.7)

    def answer(self, run: VirtualRun, often: float = 1.0) -> None:
        """Answer holds, and take an item off the belt now and then."""
        for name in list(run.state.holds):
            hold = run.state.holds.get(name)  # as the answers before have left it
            if hold is None or hold.is_pause:
                continue
            if hold.reason == 'overrun':
                assert hold.item is not None
                assert run.remove(hold.item).accepted
            elif self._chance.random() < often:
                assert run.answer(self._chance.choice(hold.answers), hold.id).accepted
        standing = [s.slot for s in run.state.sections.values() if s.slot is not None]
        if standing and self._chance.random() < 0.1:
            run.remove(self._chance.choice(standing))

    def let_everything_end(self, run: VirtualRun) -> None:
        """Take back whatever keeps jobs from ending, and start a cell that somebody stopped."""
        run.ask(StopAfter('never', BY))
        for component in list(run.state.out_of_service):
            assert run.service(component, out=False).accepted
        for name in list(run.state.jobs):
            run.control('resume', name)
            run.control('release', name)
        run.go()
        for hold in list(run.state.holds.values()):
            if hold.task == 'index':
                run.answer('mark_done', hold.id)  # before that nobody can say what stands where
        self._clear(run)
        run.command(Resume, everyones=True)
        run.go()
        assert run.ask(AddJobs((self._job('last'),), BY)).accepted
        unreleased = {job.digest: job for job in run.state.queue if job.awaits_release}
        for job in unreleased.values():
            assert run.release(job.job.script).accepted
        run.go()
        if run.state.wish is not None:
            packml = run.state.packml
            assert packml in (PackmlState.STOPPED, PackmlState.IDLE), 'no order starts it'
            if packml is PackmlState.STOPPED:
                assert run.command(Reset).accepted
            assert run.command(Start).accepted

    def _act(self, run: VirtualRun) -> Answer:
        chance = self._chance
        kind = chance.choice(KINDS)
        if kind == 'add':
            return run.ask(self._add(len(run.state.queue)))
        if kind == 'service':
            return self._service(run)
        if kind == 'script':
            return run.release(self._chance.choice(self._scripts))
        if kind == 'stop':
            return run.ask(StopAfter(chance.choice(('item', 'job', 'never', 'never')), BY))
        if kind == 'cell':
            return self._cell(run)
        if kind == 'arrange':
            return self._arrange(run)
        name = f'Q{chance.randint(0, self._given)}'
        if kind == 'move':
            return run.ask(MoveJob(name, chance.randint(1, 3), BY))
        if kind == 'next':
            return run.ask(RunNext(name, BY))
        if kind == 'requeue':
            return self._requeue(run)
        if kind == 'update':
            return run.ask(UpdateJob(self._job(name), BY))
        return run.control(chance.choice(list(CONTROLS)), name)

    def _arrange(self, run: VirtualRun) -> Answer:
        """Put jobs whose places nobody chose into any order, now and then of another queue."""
        jobs = run.state.jobs
        free = [job.job.id for job in jobs.queue() if job.ranked]
        others = iter(self._chance.sample(free, len(free)))
        wanted = [next(others) if job.ranked else job.job.id for job in jobs.queue()]
        digest = queue_digest(jobs) if self._chance.random() < 0.9 else ''
        return run.ask(Arrange(wanted, digest, BY))

    def _requeue(self, run: VirtualRun) -> Answer:
        line = run.state.jobs.line
        able = [name for name, job in line.items() if job.cycles_left and job.job.recipe]
        name = self._chance.choice([*line, *able, *able, f'Q{self._given}'])
        self._given += 1
        return run.ask(RequeueJob(name, self._job(f'Q{self._given - 1}'), BY))

    def _cell(self, run: VirtualRun) -> Answer:
        number = self._chance.randint(0, len(CELL) + 1)
        if number == len(CELL):
            return run.pause()
        return self._clear(run) if number > len(CELL) else run.command(CELL[number])

    def _service(self, run: VirtualRun) -> Answer:
        component = self._chance.choice(sorted(run.state.cell.components))
        return run.service(component, out=component not in run.state.out_of_service)

    def _clear(self, run: VirtualRun) -> Answer:
        return run.command(Clear, belt=parse_slots(believed(run.state).split(',')))

    def _add(self, queued: int) -> AddJobs:
        count = self._chance.randint(1, 2)
        jobs = tuple(self._job(f'Q{self._given + n}') for n in range(count))
        self._given += count
        position = self._chance.choice((None, None, 1, queued + 1))
        return AddJobs(jobs, BY, position, held=self._chance.random() < 0.3)

    def _job(self, name: str) -> Job:
        chance = self._chance
        start = chance.choice((None, None, 20.0, 60.0))
        terms = Terms(chance.choice((0, 0, 0, 2, -1)), start)
        recipe = chance.choice((BY_RECIPE, BY_RECIPE, None))
        quantity = chance.choice((1, 2, 2, 6))
        script = chance.choice(self._scripts)
        return Job(name, script, quantity, defaults(script), terms, recipe)
