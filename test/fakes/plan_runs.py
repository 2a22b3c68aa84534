"""Runs of drawn lines: on the product in virtual time, on the naive cell, and how they compare."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Sequence
from typing import Protocol

import yaml
from fakes.action_types import FakeActionTypes
from fakes.drawn.plan import Moment, Plan, Row
from fakes.naive_cell import NaiveCell
from fakes.virtual_run import VirtualRun
from hypothesis import note

from bt_orchestrator.model.belt_statement import believed, parse_slots
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.cell_commands import Abort, Clear, Reset, Start, Stop
from bt_orchestrator.model.events import INDEX_KEY
from bt_orchestrator.model.goal import GoalRequest
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job, Terms
from bt_orchestrator.model.packml import VERBS, possible_in
from bt_orchestrator.model.script import Script
from bt_orchestrator.proof.deadlock import deadlock
from bt_orchestrator.script.cell_file import parse_cell
from bt_orchestrator.script.script_file import parse_script

TYPES = FakeActionTypes()
COMMANDS = {'stop': Stop, 'abort': Abort, 'clear': Clear, 'reset': Reset, 'start': Start}
PATIENCE = 120
"""Decisions after which an operator has had enough: no drawn line needs nearly as many."""


class Bench(Protocol):
    """What an operator sees and does, of either cell."""

    @property
    def live(self) -> bool: ...
    @property
    def paused(self) -> bool: ...
    def wait(self, seconds: float | None) -> None: ...
    def holds(self) -> list[tuple[str, Sequence[str], str | None]]: ...
    def standing(self) -> list[str]: ...
    def answer(self, hold: str, answer: str) -> None: ...
    def remove(self, item: str) -> None: ...
    def pause(self, paused: bool) -> None: ...
    def commands(self) -> Sequence[str]:
        """Return the commands to the cell that are possible now, but for pauses."""

    def command(self, what: str) -> None: ...
    def components(self) -> Sequence[str]: ...
    def out_of_service(self) -> Sequence[str]: ...
    def service(self, component: str) -> None:
        """Take a component out of service, or bring it back."""

    def unreleased(self) -> Sequence[str]:
        """Return the names of scripts that jobs of the queue wait for."""

    def release(self, script: str) -> None: ...
    def order(self) -> bool:
        """Give the next order; return False if none is left."""


REMOVES, PAUSES, ORDERS = 7, 8, 9
GOES_ON = ('clear', 'reset', 'start')
COMMANDS_OF = {10: ('stop',), 11: GOES_ON, 12: ('abort',)}
"""Choices of an operator who does more than answer."""
RELEASES = 15
SERVICE = (13, 14)
"""Choices of one who takes a component out of service, or brings it back."""


def operate(bench: Bench, moments: Sequence[Moment]) -> bool:
    """Work until every job ended; return False if the line got stuck.

    At last everything is answered, resumed and started, and every order given.
    """
    later = itertools.repeat(None, PATIENCE)
    for moment in itertools.chain(moments, later):
        bench.wait(moment.delay_s if moment else None)
        if not bench.live and moment is None:
            if not bench.order():
                return True
            continue
        choice = moment.choice if moment else 1
        if choice == ORDERS:
            bench.order()
        elif choice in SERVICE:
            names = bench.components()
            which = choice + (int(moment.delay_s) if moment else 0)
            bench.service(names[which % len(names)])
        elif moment is None and (out := bench.out_of_service()):
            bench.service(out[0])
        elif (moment is None or choice == RELEASES) and (waited := bench.unreleased()):
            bench.release(waited[0])
        elif choice in COMMANDS_OF:
            _command(bench, COMMANDS_OF[choice])
        elif holds := bench.holds():
            hold, answers, item = holds[0]
            if 'remove_item' in answers:
                assert item is not None
                bench.remove(item)
            else:
                if moment is None:  # somebody has to let the job end
                    answers = [one for one in answers if one != 'again']
                bench.answer(hold, answers[choice % len(answers)])
        elif bench.paused:
            bench.pause(False)
        elif moment is None:
            if not _command(bench, GOES_ON):
                return False
        elif choice == REMOVES and (standing := bench.standing()):
            bench.remove(standing[choice % len(standing)])
        elif choice == PAUSES:
            bench.pause(True)
    raise AssertionError('an operator is asked again and again')


def _command(bench: Bench, meant: Sequence[str]) -> bool:
    """Give one of these commands to the cell; tell whether one is possible."""
    fitting = [one for one in bench.commands() if one in meant]
    for one in fitting:
        bench.command(one)
    return bool(fitting)


class NaiveBench:
    """The naive cell."""

    def __init__(self, plan: Plan, refused: Collection[str] = ()) -> None:
        """Begin with the first orders.

        :param refused: ids of the orders that the cell takes not
        """
        self.cell = NaiveCell(plan.cell, plan.scripts, plan.duration)
        self._refused = refused
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
        items = [hold.where['item'] for hold in holds]
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
        waited = [one.plan.name for one in self.cell.jobs if self.cell.is_unreleased(one)]
        return sorted(waited)

    def release(self, script: str) -> None:
        self.cell.release(script)

    def order(self) -> bool:
        order = next(self._orders, None)
        if order and order[0] not in self._refused:
            self.cell.submit(*order)
        return order is not None


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
        """Scripts of the orders."""
        self.refused: set[str] = set()
        """Orders whose flags cannot be shared with the ones before (4.1)."""
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
        return bool(self.run.state.pauses)

    def wait(self, seconds: float | None) -> None:
        until = self.run.now + (1e5 if seconds is None else seconds)
        self.run.sim.clock.call_at(until, lambda: None)
        self.run.go(until=until + 1e-6)  # the clock counts nanoseconds

    def holds(self) -> list[tuple[str, Sequence[str], str | None]]:
        holds = self.run.state.holds.values()
        return [(hold.id, hold.answers, hold.item) for hold in holds if not hold.is_pause]

    def standing(self) -> list[str]:
        items = [section.slot for section in self.run.state.sections.values()]
        return [item for item in items if item and self.run.state.items[item].present]

    def answer(self, hold: str, answer: str) -> None:
        assert self.run.answer(answer, hold).accepted

    def remove(self, item: str) -> None:
        assert self.run.remove(item).accepted

    def pause(self, paused: bool) -> None:
        assert (self.run.pause() if paused else self.run.resume()).accepted

    def commands(self) -> Sequence[str]:
        state = self.run.state
        found = [VERBS[cause] for cause in possible_in(state.packml)]
        is_open = any(hold.key == INDEX_KEY for hold in state.holds.values())
        return [one for one in found if one in COMMANDS and not (is_open and one == 'clear')]

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

    def order(self) -> bool:
        order = next(self._orders, None)
        if order:
            script, terms = self.scripts[order.script], Terms(order.priority, order.start)
            job = Job(order.id, script, order.quantity, terms=terms)
            answer = self.run.ask(AddJobs((job,)))
            if answer.accepted:
                self.accepted[order.id] = order.script
            else:
                assert 'the line can get stuck' in answer.message, answer
                self.refused.add(order.id)
        return order is not None


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
        'args',
        'params',
        'who',
    ),
    *('exit_status', 'counts', 'owner', 'origin', 'role', 'known', 'claims', 'uptime'),
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
}


def comparable(records: Sequence[Row]) -> list[Row]:
    """Leave out what is for people only: messages, and reasons that are sentences."""
    found = []
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
            found.append(kept)
    return found
