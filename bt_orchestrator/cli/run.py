"""The verb `run`: the tree node of a cell."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import Any

from bt_orchestrator.base.extending import of_others
from bt_orchestrator.base.stop_signals import StopSignals
from bt_orchestrator.cli.folders import (
    add_recipes_option,
    add_trees_option,
    recipe_folders,
    script_folders,
)
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.ports import EventSink
from bt_orchestrator.ros.node_parameters import NodeParameters, Words, described

DESCRIPTION = """\
Run the tree node of a cell: it takes orders, ticks the tree, sends goals, and publishes events and
status. Prints `tree node ready: ...` when it takes requests. Ends with Ctrl-C: it cancels goals
and waits at most 10 s for their ends (a second Ctrl-C leaves at once)."""

EPILOG = """\
every option but --namespace is also a ROS parameter of the node, which wins:
--ros-args -p tick_rate_hz:=20.0

exit status: 0 ended by a signal, 1 the cell file is refused, a goal did not end or the middleware
did not stop, 2 wrong use, 75 a journal in a database cannot be written: start it again"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.epilog = EPILOG
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument(
        '--namespace',
        default='',
        metavar='NS',
        help='ROS namespace of the node and of relative names in the cell file, to run two cells '
        'side by side',
    )
    parser.add_argument(
        '--sink',
        action='append',
        default=[],
        metavar='NAME',
        help='also give all events to this output of another package (entry point '
        'bt_orchestrator.sinks); may be repeated',
    )
    for name, words in described():
        if name == 'trees':
            add_trees_option(parser)
        elif name == 'recipes':
            add_recipes_option(parser)
        else:
            _add_parameter(parser, name, words)


def _add_parameter(parser: argparse.ArgumentParser, name: str, words: Words) -> None:
    default = getattr(NodeParameters(), name)
    settings: dict[str, Any] = {'default': default, 'help': words.meaning}
    if isinstance(default, bool):
        settings['action'] = argparse.BooleanOptionalAction
    elif words.choices:
        settings['choices'] = words.choices
    else:
        settings['type'] = words.read if default is None else type(default)
        settings['metavar'] = words.metavar
    if default is not None:
        shown = ('no', 'yes')[default] if isinstance(default, bool) else default
        settings['help'] += f' (default {shown})'
    parser.add_argument(f'--{name.replace("_", "-")}', **settings)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns the exit status."""
    with StopSignals() as stop:
        return _run(args, stop)


def _run(args: argparse.Namespace, stop: StopSignals) -> int:
    # Imported here, so that --help needs no ROS.
    from bt_orchestrator.cli.bootstrap import (
        build_bookkeeping,
        build_foresight,
        build_generating,
        build_stop_search,
        memory_store,
    )
    from bt_orchestrator.cli.journal_file import open_journal, open_standby
    from bt_orchestrator.ros.node import Parts, run_node

    values = {name: getattr(args, name) for name, _ in described()}
    values['trees'] = tuple(script_folders(args.trees))
    values['recipes'] = tuple(recipe_folders(args.recipes))
    defaults = NodeParameters(**values)
    ros_args = getattr(args, 'ros_args', ())
    parts = Parts(
        open_journal,
        open_standby,
        memory_store,
        build_foresight,
        build_bookkeeping,
        build_generating,
        build_stop_search,
    )
    parts = parts._replace(sinks=_sinks(args.sink))
    left = run_node(defaults, parts, stop, _say, namespace=args.namespace, ros_args=ros_args)
    for task in left:
        print(f'still running at its server: {task}', file=sys.stderr)
    return 1 if left else 0


def _sinks(names: Sequence[str]) -> Sequence[EventSink]:
    """Make outputs of other packages.

    :raises WrongUse: no package brings one of them
    """
    entry_points = of_others('sinks') if names else {}
    unknown = [name for name in names if name not in entry_points]
    if unknown:
        known = ', '.join(entry_points) or 'none'
        raise WrongUse(f'run: no installed package brings the output {unknown[0]}; found: {known}')
    return [entry_points[name].load()() for name in names]


def tree_node_main() -> int:
    """Run as `ros2 run bt_orchestrator tree_node`, which passes parameters after --ros-args."""
    from bt_orchestrator.cli.main import main

    return main(['run', *sys.argv[1:]])


def _say(line: str) -> None:
    print(line, flush=True)
