"""The verb `queue`: list the jobs of a running node, and add orders."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Protocol

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.cli.asked.derived import of_request
from bt_orchestrator.cli.command_parser import Action, in_one_line, what_to_know
from bt_orchestrator.cli.door import open_door
from bt_orchestrator.cli.node_options import add_node_options, add_who_options
from bt_orchestrator.cli.numbers import whole_32
from bt_orchestrator.cli.ordering import proposal
from bt_orchestrator.cli.ordering.order_request import give_orders
from bt_orchestrator.model.codec import to_plain
from bt_orchestrator.model.frozen import changed
from bt_orchestrator.model.jobs.isa95 import OVER
from bt_orchestrator.model.requests import About, requests_about
from bt_orchestrator.model.status import CellStatus, JobStatus
from bt_orchestrator.model.status_words import script_words
from bt_orchestrator.ports import QueuePage
from bt_orchestrator.view.screen.words import job_terms

DESCRIPTION = """\
List the queue of a running tree node, add work orders to it, or propose an order for it. `job`
changes one job of it.
Without an action: the jobs on the line, then the queue in order."""


def _add_list(parser: argparse.ArgumentParser) -> None:
    parser.description = 'List the jobs on the line, then the queue in order.'
    parser.add_argument('--json', action='store_true', help='print JSON')
    add_node_options(parser)


def _list(args: argparse.Namespace) -> int:
    with open_door(args.node, args.timeout) as door:
        status = door.status()
        status = changed(status, jobs=(*status.jobs, *others(door, status)))
    if args.json:
        jobs = [to_plain(job, whole=True) for job in status.jobs]
        print(json.dumps({'stop_after': status.stop_after, 'jobs': jobs}))
    else:
        print('\n'.join(lines(status)))
    return 0


class _Queue(Protocol):
    """The part of `ports.CellLink` that shows the queue."""

    def queue(self, after: str = '', most: int = 0) -> QueuePage: ...


def others(door: _Queue, status: CellStatus) -> list[JobStatus]:
    """Return the jobs of the queue that a status does not list."""
    listed = [job.id for job in status.jobs if job.position]
    if status.queued <= len(listed):
        return []
    known, after = set(listed), listed[-1]
    jobs: list[JobStatus] = []
    while True:
        try:
            page = door.queue(after)
        except CommandRefused:
            # What began behind a job that has left the queue meanwhile, begins with the first one.
            page = door.queue(after := '')
        if not page.jobs:
            return jobs
        after = page.jobs[-1].id
        jobs += [job for job in page.jobs if job.id not in known]
        known.update(job.id for job in page.jobs)


def lines(status: CellStatus) -> Iterator[str]:
    """Yield the queue as text."""
    waiting = [job for job in status.jobs if job.position]
    running = [job for job in status.jobs if not job.position and not _has_ended(job)]
    if status.stop_after:
        yield f'the cell stops after the current {status.stop_after}'
    yield 'on the line:' if running else 'nothing is on the line'
    yield from (f'     {_job(job)}{_done(job)}' for job in running)
    yield 'queue:' if waiting else 'the queue is empty'
    yield from (f'{job.position:4} {_job(job)}' for job in waiting)


def _job(job: JobStatus) -> str:
    state = '/'.join(word for word in (job.state.value, job.ending) if word)
    end_s = job.expected_end_s
    ends = '' if end_s is None else f', ends in about {_duration(end_s)}'
    return f'{job.id} ({script_words(job)}, {job.quantity} items): {state}{job_terms(job)}{ends}'


def _done(job: JobStatus) -> str:
    return f', {job.packed} packed'


def _duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f'{hours} h {minutes:02} min'
    return f'{minutes} min {rest:02} s' if minutes else f'{rest} s'


def _has_ended(job: JobStatus) -> bool:
    return job.state in OVER


_ADD_ORDERS, _ARRANGE = requests_about(About.QUEUE)

# --- orders ---------------------------------------------------------------------------------


def _add_add(parser: argparse.ArgumentParser) -> None:
    parser.description = what_to_know(_ADD_ORDERS)
    parser.add_argument('orders', nargs='+', type=Path, metavar='ORDER', help='work order (YAML)')
    parser.add_argument('--at', type=whole_32, default=0, metavar='N', help='place, from 1')
    parser.add_argument('--held', action='store_true', help='keep them from starting')
    parser.add_argument('--json', action='store_true', help='one JSON object an order')
    add_who_options(parser, required=False)
    add_node_options(parser)


def _add(args: argparse.Namespace) -> int:
    return give_orders(args, args.orders, position=args.at or None, held=args.held)


ACTIONS: Mapping[str, Action] = {
    'list': Action(_add_list, _list, 'list the jobs on the line, and the queue (the default)'),
    _ADD_ORDERS.word: Action(_add_add, _add, in_one_line(_ADD_ORDERS)),
    'propose': Action(
        proposal.add_arguments, proposal.run, 'propose an order of the queue, and apply it'
    ),
    _ARRANGE.word: of_request(_ARRANGE),
}
DEFAULT = 'list'
