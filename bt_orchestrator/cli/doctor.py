"""The verb `doctor`: what this machine has, what it lacks, and what to do about it."""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Iterator
from dataclasses import asdict
from importlib import util
from pathlib import Path

from bt_orchestrator.base.diagnosis import machine
from bt_orchestrator.base.diagnosis.check import Check, Verdict, fail, ok, warn, worst
from bt_orchestrator.base.diagnosis.journal_folder import journal_folder
from bt_orchestrator.base.diagnosis.ros_environment import (
    domain,
    domain_id,
    other_domains,
    reach,
    security,
)
from bt_orchestrator.base.errors import Refused
from bt_orchestrator.base.extending import ExtensionMissing
from bt_orchestrator.cli import bootstrap
from bt_orchestrator.cli.journal_file import checks_of
from bt_orchestrator.cli.numbers import seconds
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.keeping.journal_place import JournalPlace, journal_place
from bt_orchestrator.store.sqlite.keeping import readable_by_others
from bt_orchestrator.view.screen.advice import DEFAULT_NODE

DESCRIPTION = """\
Look at this machine, and with --cell at everything a cell needs on the ROS graph. Each line says
ok, warn (a cell runs, but not as one may expect) or fail, what was found, and what to do. Sends no
goal and changes nothing."""

EPILOG = 'exit status: 0 nothing failed, 1 something did, 2 wrong use'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.epilog = EPILOG
    parser.add_argument(
        '--cell',
        type=Path,
        metavar='CELL',
        help='cell file (YAML): look for its types, action servers and state topics',
    )
    parser.add_argument(
        '--node',
        metavar='NAME',
        help=f'full name of a tree node that has to run (default: {DEFAULT_NODE} may run)',
    )
    parser.add_argument(
        '--journal',
        type=journal_place,
        default=Path('journal.db'),
        metavar='FILE',
        help='where a journal is, or is to be: its folder is tried, and who may open it; of an '
        'address of a database: server, role, replicas, clock and cell (default: journal.db in '
        'the working directory)',
    )
    parser.add_argument(
        '--timeout',
        type=seconds,
        default=5.0,
        metavar='SECONDS',
        help='longest time to wait for what is missing on the graph (default 5)',
    )
    parser.add_argument('--json', action='store_true', help='one JSON object')


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns the exit status."""
    checks = []
    for check in examine(args):
        checks.append(check)
        if not args.json:
            print('\n'.join(lines(check)), flush=True)
    verdict = worst(checks)
    if args.json:
        print(as_json(checks))
    return 1 if verdict is Verdict.FAIL else 0


def lines(check: Check) -> Iterator[str]:
    """Yield a check as text."""
    yield f'{check.verdict.value:<4}  {check.name}: {check.found}'
    if check.remedy:
        yield f'      -> {check.remedy}'


def as_json(checks: list[Check]) -> str:
    """Return all checks as one JSON object."""
    plain = [{**asdict(check), 'verdict': check.verdict.value} for check in checks]
    return json.dumps({'verdict': worst(checks).value, 'checks': plain})


def examine(args: argparse.Namespace) -> Iterator[Check]:
    """Yield the checks, each at once when it is done."""
    environment = os.environ
    yield machine.python(sys.version_info[:3])
    yield machine.py_trees()
    yield machine.dot()
    yield machine.wall_clock(time.time())
    yield machine.prefixes(environment)
    yield machine.log_folder(environment)
    yield from _journal(args.journal)
    yield domain(environment)
    yield reach(environment)
    yield security(environment)
    yield from machine.interface_packages()
    cell, checks = _cell(args.cell, is_shared=not isinstance(args.journal, Path))
    yield from checks
    yield from _with_ros(args, cell)


def _journal(journal: JournalPlace) -> Iterator[Check]:
    """Try the place of a journal."""
    if isinstance(journal, Path):
        yield journal_folder(journal.absolute().parent)
        yield from _rights(journal)
        return
    try:
        yield from checks_of(journal)
    except ExtensionMissing as missing:
        yield fail('journal database', str(missing), 'install it in the environment of the node')


def _rights(journal: Path) -> Iterator[Check]:
    """Say who may open the files of a journal that is there."""
    name = 'journal files'
    try:
        wide = readable_by_others(journal)
        if wide:
            yield warn(name, wide, f'chmod 600 {journal}*, unless somebody means it so')
        elif journal.exists():
            yield ok(name, f'{journal} is for its owner alone')
    except OSError as error:
        yield warn(name, f'{journal}: {error.strerror}', 'run this as the user of the node')


def _cell(path: Path | None, *, is_shared: bool) -> tuple[Cell | None, list[Check]]:
    """Read the cell file, whose types have to be installed.

    :param is_shared: the journal is in a database, so a standby may go on with it
    """
    if path is None:
        return None, []
    try:
        cell = bootstrap.load_cell(path, bootstrap.installed_types())
    except Refused as refused:
        mistakes = refused.findings
        return None, [
            fail(
                'cell file',
                f'{mistake.file}:{mistake.line}:{mistake.column}: {mistake.what}',
                mistake.hint,
            )
            for mistake in mistakes
        ]
    types = {component.type for component in cell.components.values()}
    installed = ok('cell file', f'{path}: cell {cell.name}, {len(types)} types installed')
    return cell, [installed, _memory(cell, is_shared=is_shared)]


LEFT_S = 60.0
"""A `result_timeout` that leaves time for a standby to take over (semantics 9.4)."""


def _memory(cell: Cell, *, is_shared: bool) -> Check:
    """Say within which time a restart needs no answers of a person (semantics 9.2)."""
    shortest = min(cell.components.values(), key=lambda component: component.result_timeout_s)
    if is_shared and shortest.result_timeout_s < LEFT_S:
        return warn(
            'result_timeout',
            f'{shortest.result_timeout_s:g} s ({shortest.name}): a standby that takes over later '
            'than that asks a person about goals that were in flight',
            f'let controllers remember results for {LEFT_S:g} s or longer, and say so with '
            '`result_timeout` in the cell file',
        )
    return ok(
        'result_timeout',
        f'{shortest.result_timeout_s:g} s ({shortest.name}): a node that is started again later '
        'than that asks a person about each goal that was in flight; let controllers remember '
        'results longer, and say so with `result_timeout` in the cell file',
    )


def _with_ros(args: argparse.Namespace, cell: Cell | None) -> Iterator[Check]:
    if util.find_spec('rclpy') is None:
        remedy = 'install ROS 2 and source its setup.bash; nothing that needs it was tried'
        yield fail('rclpy', 'not installed', remedy)
        return
    from bt_orchestrator.ros.diagnosis import versions

    yield versions.rclpy_version()
    middleware = versions.middleware()
    yield middleware
    if middleware.verdict is not Verdict.FAIL:
        yield versions.executors()
        yield from _on_graph(args, cell)


def _on_graph(args: argparse.Namespace, cell: Cell | None) -> Iterator[Check]:
    from bt_orchestrator.ros.diagnosis.cell_check import cell_on_graph, tree_node
    from bt_orchestrator.ros.diagnosis.graph import Graph
    from bt_orchestrator.ros.diagnosis.participant import discovery

    exchanged = discovery()
    yield exchanged
    if exchanged.verdict is Verdict.FAIL:
        return
    node = '/' + (args.node or DEFAULT_NODE).strip('/')
    elsewhere = other_domains(domain_id(os.environ))
    with Graph(node.rpartition('/')[0] or '/') as graph:
        if cell is not None:
            yield from cell_on_graph(graph, cell, args.timeout, elsewhere)
        expected = args.node is not None
        yield from tree_node(graph, node, expected=expected, timeout_s=args.timeout)
