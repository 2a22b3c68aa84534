"""The verb `sim-cell`: real ROS 2 action servers for every component of a cell file."""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.base.stop_signals import StopSignals
from bt_orchestrator.cli.here import add_cell_option
from bt_orchestrator.cli.numbers import factor, seconds
from bt_orchestrator.cli.output import print_mistakes
from bt_orchestrator.model.cell import CONVEYOR

DESCRIPTION = """\
Start a real ROS 2 action server for every component of a cell file and for its conveyor. They have
nominal durations, results, feedback and state topics, and the faults you ask for. Prints
`sim-cell ready: ...` when all servers are up; ends with Ctrl-C."""

FAULTS = """\
faults are written COMPONENT.[TASK][#NTH]=KIND[:SECONDS], for example
    component_2a.TASK_A#2=abort   the second TASK_A is aborted
    component_2a.#3=die:5         the server dies during its third goal, and is back after 5 s
    unpacking_arm.#*=late:1.5     every task takes 1.5 s longer
  without TASK goals of all tasks are counted; NTH counts from 1 (default), * is every one, and
  0 means from the start, for the kinds that are about the server and not about a goal
kinds:
    false          ends SUCCEEDED with task_result: false
    reject         the goal is refused
    abort          ends ABORTED after its duration
    cancel         the server cancels it by itself after its duration, as if somebody else had
                   asked for it; the orchestrator holds its task as in_doubt
    hang           does not end by itself; a cancel request is obeyed
    ignore_cancel  does not end by itself; cancel requests are refused
    late:S         ends well, S seconds later
    reads:X        ends well, and every float of its result is X (NaN without X)
    mute           the request is never answered and nothing is executed
    die[:S]        half-way through the task action server and state topic vanish without an
                   answer; with S both are back after S seconds and know nothing
    absent[:S]     both are not there at first; with S they come after S seconds
    not_ready[:S]  the state topic says not ready from the goal's end on (#0: from the start),
                   for S seconds or for good
    silent         nothing is ever published on the state topic

exit status: 0 ended by Ctrl-C or SIGTERM, 1 the cell file is refused or the middleware never let
go, 2 wrong use"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.epilog = FAULTS
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    add_cell_option(parser)
    _add_selection(parser)
    _add_ros_options(parser)
    parser.add_argument(
        '--log',
        type=Path,
        metavar='FILE',
        help='append what really happens to every goal, one JSON object a line',
    )


def _add_selection(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        '--speed',
        type=factor,
        default=1.0,
        metavar='N',
        help='divide all simulated seconds by N, those of faults too (default 1)',
    )
    parser.add_argument(
        '--only',
        action='append',
        default=[],
        metavar='NAMES',
        help='simulate only these components, separated by commas; may be repeated; '
        '`conveyor` is one of them',
    )
    parser.add_argument(
        '--fail',
        action='append',
        default=[],
        metavar='COMPONENT.FAULT',
        help='make a component fail, see below; may be repeated',
    )


def _add_ros_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        '--namespace',
        type=_namespace,
        default='',
        metavar='NS',
        help='ROS namespace of relative action and topic names, to run two cells side by side; '
        'absolute names of the cell file stay unchanged',
    )
    parser.add_argument(
        '--feedback',
        type=seconds,
        default=0.5,
        metavar='SECONDS',
        help='real seconds between feedback messages of a goal; 0: only the one at its start '
        '(default 0.5)',
    )
    parser.add_argument(
        '--safety',
        action=argparse.BooleanOptionalAction,
        default=True,
        help='say on the safety input of the cell file, if it has one, that the line is safe; one '
        'process does, with the conveyor (default yes)',
    )
    parser.add_argument(
        '--result-timeout',
        type=seconds,
        metavar='SECONDS',
        help='real seconds for which a server remembers an ended goal '
        '(default: as the cell file says, else 60)',
    )


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns the exit status."""
    with StopSignals() as stop:
        return _simulate(args, stop)


def _simulate(args: argparse.Namespace, stop: StopSignals) -> int:
    # Imported here, so that --help needs no ROS.
    from bt_orchestrator.ros.types.action_types import InstalledActionTypes
    from bt_orchestrator.ros.types.messages import InstalledInterfaces
    from bt_orchestrator.script.cell_file import read_cell
    from bt_orchestrator.sim.controllers.component_server import GoalLog, UnusableLog
    from bt_orchestrator.sim.controllers.node import Setup
    from bt_orchestrator.sim.controllers.options import (
        Pace,
        WrongSelection,
        controller_names,
        select,
    )
    from bt_orchestrator.sim.controllers.process import BadRosArguments, run_controllers

    types = InstalledActionTypes()
    try:
        cell = read_cell(args.cell, types)
        components = select(cell, list(controller_names(args.only)), args.fail, types)
        has_belt = any(component.name == CONVEYOR for component in components)
        setup = Setup(
            components=components,
            safety=cell.safety if has_belt and args.safety else None,
            types=types,
            interfaces=InstalledInterfaces(),
            log=GoalLog(args.log),
            pace=Pace(args.speed, args.feedback),
            namespace=args.namespace,
            result_timeout_s=args.result_timeout,
        )
        run_controllers(setup, stop, _say_ready, getattr(args, 'ros_args', ()))
    except Refused as refused:
        print_mistakes(refused)
        return 1
    except (WrongSelection, UnusableLog, BadRosArguments) as error:
        return _wrong_use(str(error))
    return 0


def sim_cell_main() -> int:
    """Run as a program of its own, for `ros2 run` and `ros2 launch`, with --ros-args allowed."""
    with StopSignals() as stop:
        from bt_orchestrator.sim.controllers.process import BadRosArguments, without_ros_args

        parser = argparse.ArgumentParser(prog='sim_cell')
        add_arguments(parser)
        try:
            args = parser.parse_args(without_ros_args(sys.argv)[1:])
        except BadRosArguments as error:
            return _wrong_use(str(error))
        args.ros_args = sys.argv
        return _simulate(args, stop)


def _say_ready(what: str) -> None:
    print(f'sim-cell ready: {what}', flush=True)


def _namespace(text: str) -> str:
    """Read a ROS namespace."""
    if not re.fullmatch(r'(/?[A-Za-z_]\w*(/[A-Za-z_]\w*)*)?/?', text, re.ASCII):
        raise argparse.ArgumentTypeError(
            f'expected a ROS namespace such as /cell_b, found {text!r}'
        )
    return text.rstrip('/')


def _wrong_use(what: str) -> int:
    for line in what.splitlines():
        print(f'bt-orchestrator sim-cell: error: {line}', file=sys.stderr)
    return 2
