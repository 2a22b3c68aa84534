"""Forecasts from a process of their own."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator

import pytest
from fakes.shipped import REFERENCE_CELL, REFERENCE_ORDER, TREES
from patience import PATIENCE_S, until

from bt_orchestrator.base.child_process import framed
from bt_orchestrator.cli import bootstrap
from bt_orchestrator.cli.processes.foresight_process import ForesightProcess
from bt_orchestrator.model.codec import to_plain
from bt_orchestrator.model.keeping.snapshot import state_to_plain
from bt_orchestrator.sim.simulation import Simulation

EPOCH_S = 1.8e9


@pytest.fixture
def begun() -> Iterator[Simulation]:
    """The shipped order, at the moment it was queued."""
    types = bootstrap.installed_types()
    cell, given = bootstrap.load_jobs([REFERENCE_ORDER], REFERENCE_CELL, [TREES], types)
    simulation = bootstrap.build_simulation(cell, types, [])
    bootstrap.queue(simulation, given)
    yield simulation
    simulation.close()


def ask(process: ForesightProcess, simulation: Simulation) -> None:
    process.ask(json.dumps(state_to_plain(simulation.state)), {}, EPOCH_S)


def test_questions_are_answered_and_the_process_ends(begun: Simulation) -> None:
    process = ForesightProcess(begun.state.cell)
    ask(process, begun)
    until(lambda: process.ends_s, 'a forecast')

    assert process.ends_s == {'WO-1001': pytest.approx(EPOCH_S + 39.0)}
    child = process._process.pid
    assert child is not None
    process.close()
    with pytest.raises(ProcessLookupError):
        os.kill(child, 0)
    ask(process, begun)  # too late, and harmless
    assert process.ends_s == {}


def test_killed_process_loses_forecasts_and_nothing_else(
    begun: Simulation,
) -> None:
    process = ForesightProcess(begun.state.cell)
    ask(process, begun)
    until(lambda: process.ends_s, 'a forecast')
    child = process._process.pid
    assert child is not None
    os.kill(child, signal.SIGKILL)
    ask(process, begun)
    until(lambda: not process.ends_s, 'that there is none')
    process.close()


def test_process_loads_before_first_question_and_closes_unasked(begun: Simulation) -> None:
    process = ForesightProcess(begun.state.cell)
    until(lambda: process._process.pid, 'the process')
    child = process._process.pid
    assert child is not None
    process.close()
    with pytest.raises(ProcessLookupError):
        os.kill(child, 0)


def test_closed_output_pipe_is_no_error(begun: Simulation) -> None:
    words = [sys.executable, '-m', 'bt_orchestrator.cli.processes.foresight_process']
    pipe = subprocess.PIPE
    child = subprocess.Popen(words, stdin=pipe, stdout=pipe, stderr=pipe)
    assert child.stdin is not None
    assert child.stdout is not None
    child.stdout.close()
    question = {
        'state': state_to_plain(begun.state),
        'known': {'observed_s': {}, 'now_s': EPOCH_S},
    }
    for message in (to_plain(begun.state.cell), question):
        child.stdin.write(framed(json.dumps(message).encode()))
    _, errors = child.communicate(timeout=PATIENCE_S)
    assert (child.returncode, errors) == (0, b'')
