"""The verb `run`: the tree node of a cell."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from bt_orchestrator.cli.folders import add_trees_option, script_folders
from bt_orchestrator.stop_signals import StopSignals

DESCRIPTION = """\
Run the tree node of a cell: it takes orders, ticks the tree, sends goals, and tells on its topics
what happens. Prints `tree node ready: ...` when it can be asked; ends with Ctrl-C: goals are
cancelled and their ends awaited for at most 10 s (a second Ctrl-C leaves at once)."""

EPILOG = """\
every option is also a ROS parameter of the node, which wins: --ros-args -p tick_rate_hz:=20.0

exit status: 0 ended by a signal, 1 the cell file is refused or a goal had not ended,
2 wrong use"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.epilog = EPILOG
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument(
        '--cell', type=Path, default=Path(), metavar='CELL', help='cell file (YAML)'
    )
    add_trees_option(parser)
    parser.add_argument(
        '--namespace',
        default='',
        metavar='NS',
        help='ROS namespace of the node and of relative names in the cell file, so that two cells '
        'can run side by side',
    )
    parser.add_argument(
        '--executor', choices=('single', 'events'), default='single', help='rclpy executor'
    )
    parser.add_argument(
        '--journal',
        type=Path,
        metavar='FILE',
        help='durable journal (SQLite): what was begun goes on after a crash; without it nothing '
        'survives the process',
    )
    parser.add_argument(
        '--journal-synchronous',
        choices=('FULL', 'NORMAL'),
        default='FULL',
        help='FULL: a power cut loses nothing; NORMAL: quicker, a power cut may lose the last '
        'events, a crash of the program loses nothing (default FULL)',
    )
    parser.add_argument(
        '--journal-keep-jobs',
        type=int,
        default=1000,
        metavar='N',
        help='how many ended jobs keep their events in the journal, of older ones a summary '
        'stays; -1: all (default 1000)',
    )
    parser.add_argument(
        '--auto-resume',
        action='store_true',
        help='after a restart with unfinished work, go on without waiting for `resume`',
    )
    parser.add_argument(
        '--no-auto-start',
        action='store_true',
        help='wait for reset and start instead of starting when an order arrives',
    )


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns the exit status."""
    with StopSignals() as stop:
        return _run(args, stop)


def _run(args: argparse.Namespace, stop: StopSignals) -> int:
    # Imported here, so that --help needs no ROS.
    from bt_orchestrator.cli.bootstrap import (
        build_admission_check,
        build_foresight,
        memory_store,
        open_journal,
    )
    from bt_orchestrator.model.goal import SERVER_TIMEOUT_S
    from bt_orchestrator.ros.node import Parts, run_node
    from bt_orchestrator.ros.parameters import DEFAULT_TICK_RATE_HZ, NodeParameters

    defaults = NodeParameters(
        cell=args.cell,
        trees=tuple(script_folders(args.trees)),
        tick_rate_hz=DEFAULT_TICK_RATE_HZ,
        executor=args.executor,
        auto_start=not args.no_auto_start,
        auto_resume=args.auto_resume,
        journal=args.journal,
        journal_synchronous=args.journal_synchronous,
        journal_keep_jobs=args.journal_keep_jobs,
        server_timeout_s=SERVER_TIMEOUT_S,
    )
    ros_args = getattr(args, 'ros_args', ())
    parts = Parts(open_journal, memory_store, build_admission_check, build_foresight)
    left = run_node(defaults, parts, stop, _say, namespace=args.namespace, ros_args=ros_args)
    for task in left:
        print(f'still running at its server: {task}', file=sys.stderr)
    return 1 if left else 0


def tree_node_main() -> int:
    """Run as `ros2 run bt_orchestrator tree_node`, which passes parameters after --ros-args."""
    from bt_orchestrator.cli.main import main

    return main(['run', *sys.argv[1:]])


def _say(line: str) -> None:
    print(line, flush=True)
