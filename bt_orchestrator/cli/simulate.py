"""The verb `simulate`: work orders in virtual time, and what that predicts."""

from __future__ import annotations

import argparse
import dataclasses
import json
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bt_orchestrator.cli import bootstrap
from bt_orchestrator.cli.check import add_cell_options, as_json
from bt_orchestrator.cli.folders import script_folders
from bt_orchestrator.cli.forecast_text import forecast_lines, job_lines
from bt_orchestrator.cli.wrong_use import WrongUse
from bt_orchestrator.errors import Refused
from bt_orchestrator.model.codec import to_plain
from bt_orchestrator.model.state import Hold
from bt_orchestrator.ports import ActionTypes, EventSink
from bt_orchestrator.runtime.waits import PartWait
from bt_orchestrator.sim.fault_options import WrongFaults, with_faults
from bt_orchestrator.sim.forecast import Forecast
from bt_orchestrator.sim.forecast_fold import ForecastFold
from bt_orchestrator.sim.simulation import Outcome, Simulation
from bt_orchestrator.sim.standstill import standstill
from bt_orchestrator.sim.wait_log import WaitLog
from bt_orchestrator.store.trace import TraceFile, UnusableTrace

DESCRIPTION = """\
Run work orders through the real tree in virtual time, with the nominal durations of the cell file,
and print what that predicts. The orders are queued at time 0, in the order named."""

EPILOG = """\
faults are written as for sim-cell, see there: --fail component_2a.TASK_A#2=abort

exit status: 0 every job ended, 1 refused, stuck, or held without an answer, 2 wrong use"""


@dataclass(frozen=True)
class Run:
    """What a virtual run came to."""

    outcome: Outcome
    time_s: float
    forecast: Forecast
    waits: tuple[PartWait, ...]
    """Who waits for whom at the end, if it is stuck."""
    holds: tuple[Hold, ...]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.epilog = EPILOG
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument('orders', nargs='+', type=Path, metavar='ORDER', help='work order (YAML)')
    add_cell_options(parser)
    parser.add_argument(
        '--trace',
        type=Path,
        metavar='FILE',
        help='write every event, one JSON object a line, up to wherever the run gets',
    )
    parser.add_argument(
        '--fail',
        action='append',
        default=[],
        metavar='COMPONENT.FAULT',
        help='make a component fail; may be repeated',
    )
    parser.add_argument('--json', action='store_true', help='the prediction as one JSON object')


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns the exit status."""
    return simulate(args, bootstrap.installed_types())


def simulate(args: argparse.Namespace, types: ActionTypes) -> int:
    """Simulate what the options name, with the types that are known.

    :raises Refused: a file is refused, and that is not wanted as JSON
    :raises WrongUse: a fault or the trace cannot be had
    """
    try:
        done = _simulated(args, types)
    except Refused as refused:
        if not args.json:
            raise
        print(json.dumps({**as_json(refused.findings), 'outcome': 'refused'}))
        return 1
    except (WrongFaults, UnusableTrace) as error:
        raise WrongUse(str(error)) from error
    if args.json:
        print(json.dumps(_plain(done)))
    else:
        print('\n'.join(_lines(done)))
    return 0 if done.outcome is Outcome.FINISHED else 1


def _simulated(args: argparse.Namespace, types: ActionTypes) -> Run:
    folders = script_folders(args.trees)
    cell, given = bootstrap.load_jobs(args.orders, args.cell, folders, types)
    cell = with_faults(cell, args.fail, types)
    fold = ForecastFold()
    with ExitStack() as stack:
        sinks: list[EventSink] = [fold]
        if args.trace is not None:
            sinks.append(stack.enter_context(TraceFile(args.trace)))
        simulation = bootstrap.build_simulation(cell, types, sinks)
        stack.callback(simulation.close)
        bootstrap.queue(simulation, given)
        log = WaitLog()
        outcome = simulation.run(
            lambda: log.look(simulation.state, simulation.waits(), simulation.clock.now())
        )
        waits = log.end(simulation.clock.now())
        return _result(simulation, outcome, fold.forecast(cell, waits))


def _result(simulation: Simulation, outcome: Outcome, forecast: Forecast) -> Run:
    is_stuck = outcome is Outcome.STUCK
    waits = standstill(simulation.state, simulation.waits()) if is_stuck else []
    holds = tuple(simulation.state.holds.values())
    return Run(outcome, simulation.clock.now(), forecast, tuple(waits), holds)


# --- as text ----------------------------------------------------------------------------------


def _lines(done: Run) -> Iterator[str]:
    if done.outcome is Outcome.FINISHED:
        yield from forecast_lines(done.forecast)
        return
    yield f'{done.outcome.value} at {done.time_s:.1f} s:'
    for wait in done.waits:
        yield f'  {wait}'
    for hold in done.holds:
        yield from _hold_lines(hold)
    yield ''
    yield from job_lines(done.forecast)


def _hold_lines(hold: Hold) -> Iterator[str]:
    subject = hold.item if hold.key is None else hold.key
    where = '' if hold.section is None else f', section {hold.section}'
    message = f' ({hold.message})' if hold.message else ''
    yield f'  hold {hold.id}{where}: {subject}: {hold.reason}{message}'
    yield f'    possible answers: {", ".join(hold.answers)}'


# --- as data ----------------------------------------------------------------------------------


def _plain(done: Run) -> dict[str, Any]:
    slowest = done.forecast.bottleneck
    return {
        **as_json(()),
        'ok': done.outcome is Outcome.FINISHED,
        'outcome': done.outcome.value,
        'time_s': done.time_s,
        'forecast': dataclasses.asdict(done.forecast),
        'bottleneck': None if slowest is None else dataclasses.asdict(slowest),
        'waits': [_plain_wait(wait) for wait in done.waits],
        'holds': [dataclasses.asdict(hold) for hold in done.holds],
    }


def _plain_wait(wait: PartWait) -> dict[str, Any]:
    return {'part': wait.part, **to_plain(wait.wait)}
