"""What would become of jobs after some requests."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from fakes.action_types import FakeActionTypes
from fakes.line import THREE, Line
from fakes.operator import ann

from bt_orchestrator.errors import CommandRefused
from bt_orchestrator.model.commands import AnswerHold, Command
from bt_orchestrator.model.jobs.job_commands import ControlJob, RunNext
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.requests import About, Asked, ask
from bt_orchestrator.model.snapshot import state_to_plain
from bt_orchestrator.model.state import CellState
from bt_orchestrator.ports import Consequence
from bt_orchestrator.sim.simulation import Simulation
from bt_orchestrator.sim.what_if import EngineWhatIf
from bt_orchestrator.store.memory import MemoryStore

TYPES = FakeActionTypes()
LINE = Line(3, seconds={'a2': 5.0})


def command_of(asked: Asked, state: CellState) -> Command:
    if asked.request.about is About.HOLD:
        return AnswerHold(str(asked.arguments['hold']), asked.request.word, asked.by)
    job = str(asked.arguments['job'])
    if job == 'unreadable':
        raise CommandRefused('this cannot be read')
    if asked.request.word == 'next':
        return RunNext(job, asked.by)
    return ControlJob(asked.request.word, job, asked.by)


@contextmanager
def running(until_s: float, text: str = THREE, fails: str = '') -> Iterator[Simulation]:
    line = Line(3, seconds={'a2': 5.0}, faults={fails: 'abort'} if fails else None)
    simulation = Simulation(line.cell, TYPES, MemoryStore())
    script = line.script(text)
    simulation.submit(Job(name, script, 3) for name in ('A', 'B', 'C'))
    while (due := simulation.clock.next_deadline()) is not None and due <= until_s:
        simulation.clock.advance()
        simulation.orchestrator.settle()
    yield simulation
    simulation.close()


def asked_of(simulation: Simulation, *requests: Asked) -> Consequence:
    plain = json.loads(json.dumps(state_to_plain(simulation.state)))
    now_s = simulation.clock.now()
    what_if = EngineWhatIf(simulation.state.cell, TYPES, plain, {}, now_s, command_of)
    return what_if.ask(requests)


def test_a_job_that_comes_first_ends_earlier_and_the_others_later() -> None:
    with running(4.0) as simulation:
        found = asked_of(simulation, ask('job.next', ann(), job='C'))
        before, after = dict(found.before), dict(found.after)
        assert list(before) == ['A', 'B', 'C']
        assert list(after) == ['A', 'C', 'B']
        assert after['A'] == before['A']
        assert after['C'] is not None
        assert after['C'] == before['B']
        assert after['B'] == before['C']
        assert found.refusals == ()
        # Nothing of it happens: the run itself comes to what was expected of it.
        now_s = simulation.clock.now()
        ends: dict[str, float] = {}
        while simulation.state.jobs:
            simulation.clock.advance()
            simulation.orchestrator.settle()
            for job in simulation.state.ended.values():
                ends.setdefault(job.job.id, simulation.clock.now() - now_s)
        assert ends == pytest.approx(before)


def test_refusals_are_told_and_the_others_are_carried_out() -> None:
    with running(4.0) as simulation:
        found = asked_of(
            simulation,
            ask('job.resume', ann(), job='A'),
            ask('job.hold', ann(), job='unreadable'),
            ask('job.cancel', ann(), job='B'),
        )
        assert len(found.refusals) == 2
        assert found.refusals[0].startswith('job.resume: A is Running; ')
        assert found.refusals[1] == 'job.hold: this cannot be read'
        assert list(dict(found.after)) == ['A', 'C']


def test_a_job_that_is_kept_from_starting_has_no_end() -> None:
    with running(4.0) as simulation:
        found = asked_of(simulation, ask('job.hold', ann(), job='B'))
        assert dict(found.after)['B'] is None
        assert dict(found.after)['C'] == dict(found.before)['B']
