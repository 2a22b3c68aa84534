"""Runs of drawn lines: on the product in virtual time, on the naive cell, and how they compare."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import yaml
from fakes.action_types import FakeActionTypes
from fakes.commands import (
    Abort,
    Arrange,
    CellCommand,
    Clear,
    ControlJob,
    MoveJob,
    Reset,
    Resume,
    RunNext,
    Start,
    Stop,
    StopAfter,
)
from fakes.drawn.plan import UPDATES, Plan, Row
from fakes.naive_cell import NaiveCell
from fakes.virtual_run import BY, VirtualRun
from hypothesis import note

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.commands import Command
from bt_orchestrator.model.events import INDEX_KEY
from bt_orchestrator.model.goal import GoalRequest
from bt_orchestrator.model.jobs.isa95 import job_word
from bt_orchestrator.model.jobs.job_commands import AddJobs, RequeueJob, UpdateJob
from bt_orchestrator.model.jobs.job_control import JobFacts
from bt_orchestrator.model.jobs.order import Job, RecipeChoice, Terms
from bt_orchestrator.model.judging.belt_statement import believed, parse_slots
from bt_orchestrator.model.packml import VERBS, possible_in
from bt_orchestrator.model.proof.deadlock import deadlock
from bt_orchestrator.model.requests.offers import of_job
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.state.proposed import queue_digest
from bt_orchestrator.model.stop_reason import AFTER, NEVER
from bt_orchestrator.script.cell_file import parse_cell
from bt_orchestrator.script.script_file import parse_script

TYPES = FakeActionTypes()
BY_RECIPE = RecipeChoice(('R-3',))
COMMANDS: Mapping[str, CellCommand] = {
    'stop': Stop,
    'abort': Abort,
    'clear': Clear,
    'reset': Reset,
    'start': Start,
}


class NaiveBench:
    """The naive cell."""

    def __init__(self, plan: Plan, refused: Collection[str] = ()) -> None:
        """Begin with the first orders.

        :param refused: ids of the orders that the cell takes not
        """
        self.cell = NaiveCell(plan.cell, plan.scripts, plan.duration)
        self._refused = refused
        self._asked = 0
        self._orders = iter((*plan.orders, *plan.later))
        for _ in plan.orders:
            self.order()

    @property
    def live(self) -> bool:
        return bool(self.cell.jobs)

    @property
    def paused(self) -> bool:
        return any(hold.reason == 'paused' for hold in self.cell.holds)

    def wait(self, seconds: float | None) -> None:
        self.cell.advance(self.cell.now + (1e5 if seconds is None else seconds))

    def holds(self) -> list[tuple[str, Sequence[str], str | None]]:
        holds = [hold for hold in self.cell.holds if hold.reason != 'paused']
        items = [hold.where.get('item') for hold in holds]
        answers = [self.cell.offered(h.task) if h.task else h.answers for h in holds]
        return [
            (hold.id, offered, item and item.id)
            for hold, offered, item in zip(holds, answers, items, strict=True)
        ]

    def standing(self) -> list[str]:
        return [item.id for item in self.cell.slots().values() if not item.empty]

    def answer(self, hold: str, answer: str) -> None:
        self.cell.operate(answer, hold=next(h for h in self.cell.holds if h.id == hold))

    def remove(self, item: str) -> None:
        items = self.cell.slots().values()
        self.cell.operate('remove_item', item=next(i for i in items if i.id == item))

    def pause(self, paused: bool) -> None:
        self.cell.operate('pause' if paused else 'resume')

    def commands(self) -> Sequence[str]:
        return self.cell.commands()

    def command(self, what: str) -> None:
        self.cell.command(what)

    def components(self) -> Sequence[str]:
        return sorted(device.name for device in self.cell.devices.values())

    def out_of_service(self) -> Sequence[str]:
        return self.cell.out

    def service(self, component: str) -> None:
        self.cell.service(component)

    def unreleased(self) -> Sequence[str]:
        waited = [job.plan.name for job in self.cell.jobs if self.cell.is_unreleased(job)]
        return sorted(waited)

    def release(self, script: str) -> None:
        self.cell.release(script)

    def telling(self) -> Sequence[str]:
        given = self.cell.devices.values()
        return sorted(part.name for part in given if 'reads' in str(part.given.get('changes')))

    def set_up(self, component: str, value: str) -> None:
        self.cell.note_told(component, 'tool', value)

    def order(self) -> bool:
        order = next(self._orders, None)
        if order and order[0] not in self._refused:
            self.cell.submit(*order)
        return order is not None

    def possible(self) -> list[tuple[str, str]]:
        return self.cell.possible()

    def ways_to_empty(self) -> Sequence[str]:
        return self.cell.ways_to_empty()

    def run_empty(self, after: str) -> None:
        self.cell.run_empty(after)

    def free(self) -> list[str]:
        return [job.id for job in self.cell.queue if job.rank is not None]

    def arrange(self, jobs: Sequence[str]) -> None:
        self.cell.arrange(jobs)

    def ask(self, what: str, job: str, number: int) -> None:
        self._asked += 1
        if f'{what} {self._asked}' not in self._refused:
            self.cell.ask(what, job, 1 + number % 3 if what == 'move' else number)


class ProductBench:
    """The product in virtual time."""

    def __init__(self, plan: Plan, *, viewed: bool = False) -> None:
        self.plan = plan
        self.cell = product_cell(plan)
        self.run = VirtualRun(
            self.cell, TYPES, rebuild=plan.rebuilds, duration=self._duration, viewed=viewed
        )
        self._counts: dict[str, int] = {}
        self.scripts = product_scripts(plan, self.cell)
        self._orders = iter((*plan.orders, *plan.later))
        self.accepted: dict[str, str] = {}
        """Scripts of the orders, as last changed."""
        self.refused: set[str] = set()
        """Orders, and changes of them, whose flags cannot be shared with the ones before (4.1)."""
        self._asked = 0
        for _ in plan.orders:
            self.order()

    def _duration(self, request: GoalRequest) -> float:
        name = request.component
        self._counts[name] = self._counts.get(name, 0) + 1
        drawn = self.plan.duration(name, self._counts[name])
        component = self.cell.components[name]
        return component.duration_s(request.task) if drawn is None else drawn

    @property
    def live(self) -> bool:
        return not self.run.ended

    @property
    def paused(self) -> bool:
        return any(hold.reason == 'paused' for hold in self.run.state.pauses)

    def wait(self, seconds: float | None) -> None:
        until = self.run.now + (1e5 if seconds is None else seconds)
        self.run.sim.clock.call_at(until, lambda: None)
        self.run.go(until=until + 1e-6)  # the clock counts nanoseconds

    def holds(self) -> list[tuple[str, Sequence[str], str | None]]:
        holds = self.run.state.holds.values()
        return [(hold.id, hold.answers, hold.item) for hold in holds if hold.reason != 'paused']

    def standing(self) -> list[str]:
        items = [section.slot for section in self.run.state.sections.values()]
        return [item for item in items if item and self.run.state.items[item].present]

    def answer(self, hold: str, answer: str) -> None:
        if answer == 'resume':
            assert self.run.command(Resume, hold=hold).accepted
        else:
            assert self.run.answer(answer, hold).accepted

    def remove(self, item: str) -> None:
        assert self.run.remove(item).accepted

    def pause(self, paused: bool) -> None:
        assert (self.run.pause() if paused else self.run.resume()).accepted

    def commands(self) -> Sequence[str]:
        state = self.run.state
        verbs = [VERBS[cause] for cause in possible_in(state.packml)]
        is_open = any(hold.key == INDEX_KEY for hold in state.holds.values())
        return [verb for verb in verbs if verb in COMMANDS and not (is_open and verb == 'clear')]

    def command(self, what: str) -> None:
        more: Row = {}
        if what == 'clear':
            more['belt'] = parse_slots(believed(self.run.state).split(','))
        assert self.run.command(COMMANDS[what], **more).accepted

    def components(self) -> Sequence[str]:
        return sorted(self.cell.components)

    def out_of_service(self) -> Sequence[str]:
        return list(self.run.state.out_of_service)

    def service(self, component: str) -> None:
        out = component not in self.run.state.out_of_service
        assert self.run.service(component, out=out).accepted

    def unreleased(self) -> Sequence[str]:
        return sorted(job.job.script.name for job in self.run.state.queue if job.awaits_release)

    def release(self, script: str) -> None:
        assert self.run.release(self.scripts[script]).accepted

    def telling(self) -> Sequence[str]:
        components = self.cell.components.values()
        names = (part.name for part in components for made in part.setups.values() if made.reads)
        return sorted(names)

    def set_up(self, component: str, value: str) -> None:
        self.run.sim.gateway.set_up(component, 'tool', value)

    def order(self) -> bool:
        order = next(self._orders, None)
        if order:
            script, terms = self.scripts[order.script], Terms(order.priority, order.start)
            recipe = BY_RECIPE if order.by_recipe else None
            params = {'setup': order.setup}
            job = Job(order.id, script, order.quantity, params, terms=terms, recipe=recipe)
            answer = self.run.ask(AddJobs((job,)))
            if answer.accepted:
                self.accepted[order.id] = order.script
            else:
                assert 'the line can get stuck' in answer.message, answer
                self.refused.add(order.id)
        return order is not None

    def possible(self) -> list[tuple[str, str]]:
        state = self.run.state
        pairs = []
        for job in state.jobs.values():
            facts = JobFacts(
                job_word(state, job),
                job.ending,
                awaits_start=job.awaits_start,
                unreleased=job.unreleased,
                unavailable=job.unavailable,
                is_held=job.held,
                is_by_recipe=job.job.recipe is not None,
                left=job.cycles_left,
                piece=job.piece,
                piece_left=job.piece_left,
            )
            words = {request.word for request in of_job(facts)}
            if not job.paused:  # the whole cell is
                words.discard('resume')
            pairs += [(word, job.job.id) for word in sorted(words)]
        return pairs

    def ways_to_empty(self) -> Sequence[str]:
        state = self.run.state
        ways = AFTER if state.on_the_line else ()
        return [*ways, *([NEVER] if state.stop_after else [])]

    def run_empty(self, after: str) -> None:
        assert self.run.ask(StopAfter(after, BY)).accepted

    def free(self) -> list[str]:
        return [job.job.id for job in self.run.state.queue if job.ranked]

    def arrange(self, jobs: Sequence[str]) -> None:
        live, others = self.run.state.jobs, iter(jobs)
        wanted = [next(others) if job.ranked else job.job.id for job in live.queue()]
        assert self.run.ask(Arrange(wanted, queue_digest(live), BY)).accepted

    def ask(self, what: str, job: str, number: int) -> None:
        self._asked += 1
        command = self._asking(what, job, number)
        answer = self.run.ask(command)
        if answer.accepted and isinstance(command, UpdateJob):
            self.accepted[job] = command.job.script.name
        if not answer.accepted:
            assert what in ('update', 'requeue'), answer
            assert 'the line can get stuck' in answer.message, answer
            self.refused.add(f'{what} {self._asked}')

    def _asking(self, what: str, job: str, number: int) -> Command:
        if what == 'move':
            place = min(1 + number % 3, len(self.run.state.queue))
            return MoveJob(job, place, BY)
        if what == 'next':
            return RunNext(job, BY)
        if what == 'requeue':
            had = self.run.state.jobs[job].job
            return RequeueJob(job, replace(had, id=f'{job}-rest'), BY)
        if what == 'update':
            return UpdateJob(self._changed(job, number), BY)
        return ControlJob(what, job, BY)

    def _changed(self, name: str, number: int) -> Job:
        change, now = UPDATES[number % len(UPDATES)], self.run.state.jobs[name].job
        scripts = list(self.scripts.values())
        script = scripts[number % len(scripts)] if change.script else now.script
        terms = Terms(change.priority, change.start or now.terms.start)
        return Job(name, script, change.quantity, now.params, terms=terms)


def text_of(data: Row) -> str:
    """Return a file of plain data."""
    return str(yaml.dump(data, Dumper=yaml.CSafeDumper, sort_keys=False, width=99))


def product_cell(plan: Plan) -> Cell:
    """Read the cell file of a plan."""
    return parse_cell(text_of(plan.cell), 'cell.yaml', TYPES)


def product_scripts(plan: Plan, cell: Cell) -> dict[str, Script]:
    """Read the scripts of a plan."""
    return {
        script['script']: parse_script(text_of(script), f'{script["script"]}.yaml', cell, TYPES)
        for script in plan.scripts
    }


def show(plan: Plan) -> None:
    """Print a plan with its failure."""
    note('\n'.join(map(text_of, (plan.cell, *plan.scripts))))
    note(f'{plan.orders} {plan.later} {plan.moments} {plan.seconds} {sorted(plan.rebuilds)}')


def refused(plan: Plan) -> set[str]:
    """Return the scripts that `check` refuses because they get stuck."""
    scripts = product_scripts(plan, product_cell(plan))
    return {name for name, script in scripts.items() if deadlock(script) is not None}


UNSEEN = {
    'operator.refused',
    'request.refused',
    'script.loaded',
    'orchestrator.started',
    'component.state_changed',
    'component.setup_read',
    'cell.stop_reason_changed',
}
"""Events about files and processes, of which the rules of the line say nothing, and the reason why
it stands, which test_7_stop_reasons is about."""
WORDS = (
    *(
        'seq',
        'goal',
        'server',
        'digest',
        'cell_digest',
        'definition',
        'message',
        *('controller_said', 'last_feedback', 'topic_says'),
        'args',
        'params',
        'who',
    ),
    *('choice', 'exit_status', 'counts', 'owner', 'origin', 'role', 'known', 'claims', 'uptime'),
)
WORDED = {
    'task.skipped',
    'item.rejected',
    'item.nonconforming',
    'job.aborting',
    'cell.state_changed',
    'operator.decided',
    'component.out_of_service',
    'script.released',
    'job.aborted',
    'job.stopping',
    'job.completed',
}


def comparable(records: Sequence[Row]) -> list[Row]:
    """Leave out what is for people only: messages, and reasons that are sentences."""
    rows = []
    for record in records:
        if record['event'] not in UNSEEN:
            kept = {name: value for name, value in record.items() if name not in WORDS}
            if record['event'] in WORDED:
                kept.pop('reason', None)
            if record['event'] == 'cell.state_changed':
                del kept['cause']
            for name in ('time', 'not_before'):
                if name in kept:
                    kept[name] = round(kept[name], 6)
            rows.append(kept)
    return rows
