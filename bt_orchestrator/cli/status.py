"""The verb `status`: how a running node's cell stands."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from typing import Any

from bt_orchestrator.cli.node_options import add_node_options


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = 'Print how the cell of a running tree node stands.'
    parser.add_argument('--json', action='store_true', help='the whole status as one JSON object')
    add_node_options(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns the exit status."""
    from bt_orchestrator.ros.client import NodeClient
    from bt_orchestrator.ros.messages import to_plain

    with NodeClient(args.node, args.timeout) as client:
        status = client.status()
    if args.json:
        print(json.dumps(to_plain(status)))
    else:
        print('\n'.join(lines(status)))
    return 0


def lines(status: Any) -> Iterator[str]:
    """Yield a status as text."""
    yield f'cell {status.cell}: {status.state}, belt {_belt(status)}'
    if status.journal_failure:
        yield f'  NOTHING IS DONE ANY MORE: {status.journal_failure}'
    for job in status.jobs:
        yield _job(job)
    for reason in status.initialization_waiting:
        yield f'  initialization  {reason}'
    for section in status.sections:
        yield f'  section {section.section:<3} {_slot(section):<14} {_work(section)}'
    for component in status.components:
        if not component.available:
            yield f'  {component.name}: no action server at {component.action}'
    for flag in status.flags:
        yield f'  flag {flag.name}: {flag.count} of {flag.capacity}'
    for hold in status.holds:
        yield _hold(hold)


def _belt(status: Any) -> str:
    return 'moving' if status.belt_moving else 'at rest'


def _job(job: Any) -> str:
    named = ('rejected', 'missing', 'nonconforming')
    bad = [f'{getattr(job, name)} {name}' for name in named if getattr(job, name)]
    counts = ', '.join([f'{job.packed} of {job.quantity} packed', *bad])
    return f'  {job.id} ({job.script}): {job.state}, {counts}'


def _slot(section: Any) -> str:
    if section.slot_empty_position:
        return f'({section.slot})'
    return section.slot or '-'


def _work(section: Any) -> str:
    running = [f'{task.id} {task.name} at {task.action}' for task in section.running]
    return '; '.join([*running, *section.waiting])


def _hold(hold: Any) -> str:
    where = f'section {hold.section}, ' if hold.section else ''
    what = f'{hold.task} of {hold.item or hold.job}' if hold.task else hold.item
    message = f' ({hold.message})' if hold.message else ''
    return (
        f'  hold {hold.id}: {where}{what}: {hold.reason}{message}; '
        f'answer with {" | ".join(hold.answers)}'
    )
