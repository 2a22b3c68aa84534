"""A queue may be long: the line works, and looks, as if a few jobs waited.

Counted in calls and behaviours, which are the same on every machine.
"""

from __future__ import annotations

from collections.abc import Mapping

import pytest
from fakes.calls import calls
from fakes.commands import ControlJob, MoveJob
from fakes.line import THREE, Line, with_initialization, with_section
from fakes.operator import ann
from py_trees.common import Status

from bt_orchestrator.engine.tree.section import Section
from bt_orchestrator.engine.tree.sharing import Part, Parts, uses_of
from bt_orchestrator.model.commands import Command
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.script import Script
from bt_orchestrator.sim.simulation import Simulation
from bt_orchestrator.store.memory import MemoryStore

LINE = Line()
BY = ann('a test')
FEW, MANY = 10, 1500

ZONED = (
    with_initialization('[{id: prepare, @a2.PREPARE}]')
    + '\nlateral_dependencies:\n  - {flag: full, upstream: place, downstream: work, capacity: 2}\n'
    + 'zones: {middle: [work, pack]}\n'
)


def waiting_line(number: int, *, held: bool = False) -> Simulation:
    """Return a line that works on J, with some jobs behind it."""
    simulation = Simulation(LINE.cell, LINE.types, MemoryStore())
    script = LINE.script(ZONED)
    add(simulation, 'J', script, 3)
    jobs = tuple(Job(f'Q-{n}', script, 2) for n in range(number))
    assert simulation.orchestrator.ask(AddJobs(jobs, BY, held=held)).accepted
    add(simulation, 'LAST', script, 2)
    go_on(simulation, 4)
    return simulation


def add(simulation: Simulation, name: str, script: Script, quantity: int = 1) -> None:
    """Queue a job."""
    answer = simulation.orchestrator.ask(AddJobs((Job(name, script, quantity),), BY))
    assert answer.accepted, answer


def go_on(simulation: Simulation, settles: int) -> None:
    for _ in range(settles):
        assert simulation.clock.advance()
        simulation.orchestrator.settle()


def behaviours(simulation: Simulation) -> list[str]:
    return [behaviour.name for behaviour in simulation.orchestrator.tree.root.iterate()]


def test_waiting_jobs_do_not_enlarge_tree() -> None:
    few, many = waiting_line(FEW), waiting_line(MANY)
    assert len(many.state.jobs) == MANY + 2
    assert behaviours(many) == behaviours(few)


@pytest.mark.parametrize('held', [False, True])
def test_waiting_jobs_do_not_slow_line(held: bool) -> None:
    few, many = waiting_line(FEW, held=held), waiting_line(MANY, held=held)
    begun, done = len(many.state.queue), calls(lambda: go_on(few, 30))
    assert calls(lambda: go_on(many, 30)) <= 1.2 * done
    assert len(many.state.queue) < begun


@pytest.mark.parametrize('held', [False, True])
@pytest.mark.parametrize(
    'command',
    [
        AddJobs((Job('NEW', LINE.script(ZONED), 1),), BY),
        AddJobs((Job('NEW', LINE.script(THREE), 1),), BY, position=2),
        MoveJob('LAST', 2, BY),
        *(ControlJob(verb, 'LAST', BY) for verb in ('hold', 'cancel', 'abort')),
        ControlJob('pause', 'NOBODY', BY),
    ],
    ids=['add', 'insert', 'move', 'hold', 'cancel', 'abort', 'refused'],
)
def test_waiting_jobs_do_not_slow_commands(command: Command, held: bool) -> None:
    few, many = waiting_line(FEW, held=held), waiting_line(MANY, held=held)
    done = calls(lambda: few.orchestrator.ask(command))
    assert calls(lambda: many.orchestrator.ask(command)) <= 2 * done
    assert few.orchestrator.ask(command).accepted == many.orchestrator.ask(command).accepted


def test_the_index_follows_scripts_and_not_jobs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Which parts share what is worked out when a script comes to the line."""
    simulation = waiting_line(FEW)
    counted: list[Script] = []

    def noted(script: Script, bits: Mapping[Part, int]) -> dict[tuple[str, str | int], Parts]:
        counted.append(script)
        return uses_of(script, bits)

    monkeypatch.setattr('bt_orchestrator.engine.tree.sharing.uses_of', noted)
    go_on(simulation, 30)
    assert not counted
    other = LINE.script(with_section(2, '- {id: other, @b2}'))
    add(simulation, 'OTHER', other)
    assert not counted
    while simulation.state.jobs:
        go_on(simulation, 1)
    assert counted == [other]


def test_next_job_gets_its_branches() -> None:
    simulation = waiting_line(2)
    tree = simulation.orchestrator.tree
    assert [name for name in simulation.state.jobs if tree.has(name)] == ['J', 'Q-0']
    assert simulation.orchestrator.ask(ControlJob('hold', 'Q-0', BY)).accepted
    assert [name for name in simulation.state.jobs if tree.has(name)] == ['J', 'Q-1']
    assert simulation.orchestrator.ask(MoveJob('LAST', 1, BY)).accepted
    assert [name for name in simulation.state.jobs if tree.has(name)] == ['J', 'LAST']
    assert simulation.orchestrator.ask(ControlJob('release', 'Q-0', BY)).accepted
    while 'J' in simulation.state.jobs:
        go_on(simulation, 1)
    with_branches = [name for name in simulation.state.jobs if tree.has(name)]
    assert with_branches == [*simulation.state.jobs.line, simulation.state.queue[0].job.id]


def test_of_a_held_queue_no_job_has_branches() -> None:
    simulation = Simulation(LINE.cell, LINE.types, MemoryStore())
    jobs = tuple(Job(name, LINE.script(THREE), 1) for name in 'JKL')
    assert simulation.orchestrator.ask(AddJobs(jobs, BY, held=True)).accepted
    assert not any(simulation.orchestrator.tree.has(name) for name in 'JKL')


def test_aborted_queued_job_skips_initialization_at_once() -> None:
    simulation = waiting_line(FEW)
    assert simulation.orchestrator.ask(ControlJob('abort', 'LAST', BY)).accepted
    assert 'LAST' not in simulation.state.jobs
    assert simulation.state.ended['LAST'].exit_status == 'aborted'


def test_queue_changes_alone_wake_no_section(monkeypatch: pytest.MonkeyPatch) -> None:
    simulation = waiting_line(FEW)
    ticked: list[Section] = []
    run = Section.run

    def noted(section: Section) -> Status:
        ticked.append(section)
        return run(section)

    monkeypatch.setattr(Section, 'run', noted)
    script = LINE.script(ZONED)
    commands: list[Command] = [
        AddJobs((Job('NEW', script, 1), Job('HELD', script, 1)), BY),
        MoveJob('NEW', 3, BY),
        *(ControlJob(verb, 'HELD', BY) for verb in ('hold', 'release', 'cancel', 'resume')),
    ]
    for command in commands:
        simulation.orchestrator.ask(command)
        assert not ticked, command
    assert simulation.orchestrator.ask(MoveJob('NEW', 1, BY)).accepted
    assert ticked
