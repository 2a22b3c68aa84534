"""The verb `queue`: list the jobs of a running node, and change what is done when."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, Protocol

from bt_orchestrator.cli.node_options import add_node_options, add_who_options, origin
from bt_orchestrator.cli.numbers import whole_32
from bt_orchestrator.cli.order_request import add_request, key_values, script_name, show_orders
from bt_orchestrator.cli.order_terms import add_term_options, changed_terms
from bt_orchestrator.cli.wrong_use import WrongUse
from bt_orchestrator.model.codec import to_plain
from bt_orchestrator.model.frozen import changed
from bt_orchestrator.model.jobs.isa95 import OVER
from bt_orchestrator.model.status import CellStatus, JobStatus
from bt_orchestrator.screen.words import job_terms

CONTROLS = (
    'hold',
    'release',
    'next',
    'remove',
    'pause',
    'resume',
    'stop',
    'abort',
    'cancel',
    'clear',
)
AFTER = ('item', 'job', 'never')

DESCRIPTION = """\
List and change the queue of a running tree node. Without an action: the jobs on the line, then the
queue in order.

  queue add ORDER...         queue work orders, all or none; --at N, --held
  queue move JOB N           put a queued job at place N, counted from 1
  queue next JOB             put it in front of all others, and release it
  queue update JOB           change it: --quantity, --param NAME=VALUE, --script, --priority,
                             --start, --due, --details
  queue hold|release JOB     keep a queued job from starting, or let it start in its turn
  queue remove|cancel JOB    take a queued job out
  queue pause|resume JOB     let a running job begin no more items, or go on
  queue stop JOB             end a job early: items on the line are finished
  queue abort JOB            end a job now: items on the line are rejected and drain
  queue clear JOB            list an ended job no more
  queue stop-after WHAT      item or job: run the line empty, then stop; never: take that back"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    actions = ('list', 'add', 'move', 'update', *CONTROLS, 'stop-after')
    parser.add_argument(
        'action', nargs='?', default='list', choices=actions, help='what to do (default: list)'
    )
    parser.add_argument('what', nargs='*', metavar='WHAT', help='orders, a job, a place')
    parser.add_argument('--at', type=whole_32, default=0, metavar='N', help='add: place, from 1')
    parser.add_argument('--held', action='store_true', help='add: keep them from starting')
    parser.add_argument(
        '--quantity', type=whole_32, default=0, metavar='N', help='update: quantity'
    )
    parser.add_argument(
        '--param',
        action='append',
        default=[],
        metavar='NAME=VALUE',
        help='update: a parameter; may be given several times',
    )
    parser.add_argument(
        '--script', default='', metavar='SCRIPT', help='update: script, read anew by the node'
    )
    add_term_options(parser)
    parser.add_argument('--json', action='store_true', help='print JSON')
    add_who_options(parser, required=False)
    add_node_options(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns 1 when it was refused."""
    if args.action == 'list':
        _expect(args, 0, 'nothing')
        return _list(args)
    if args.action != 'add' and not args.reason:
        raise WrongUse(f'queue {args.action}: say why, with --reason TEXT')
    ask = _ASK.get(args.action, _control)
    return ask(args)


def _list(args: argparse.Namespace) -> int:
    from bt_orchestrator.ros.link.client import NodeClient

    with NodeClient(args.node, args.timeout) as client:
        status = client.status()
        status = changed(status, jobs=(*status.jobs, *others(client, status)))
    if args.json:
        jobs = [to_plain(job, whole=True) for job in status.jobs]
        print(json.dumps({'stop_after': status.stop_after, 'jobs': jobs}))
    else:
        print('\n'.join(lines(status)))
    return 0


class _Client(Protocol):
    def call(self, kind: Any, service: str, request: Any) -> Any: ...


def others(client: _Client, status: CellStatus) -> list[JobStatus]:
    """Return the jobs of the queue that a status does not list."""
    from bt_orchestrator_interfaces.srv import QueueList

    from bt_orchestrator.ros.types.job_messages import job_status

    listed = [job.id for job in status.jobs if job.position]
    if status.queued <= len(listed):
        return []
    known, after = set(listed), listed[-1]
    found: list[JobStatus] = []
    while True:
        answer = client.call(QueueList, 'queue/list', QueueList.Request(after=after))
        if answer.accepted and not answer.jobs:
            return found
        # What began behind a job that has left the queue meanwhile, begins with the first one.
        after = answer.jobs[-1].id if answer.accepted else ''
        found += [job_status(job) for job in answer.jobs if job.id not in known]
        known.update(job.id for job in answer.jobs)


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
    return f'{job.id} ({job.script}, {job.quantity} items): {state}{job_terms(job)}{ends}'


def _done(job: JobStatus) -> str:
    return f', {job.packed} packed'


def _duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f'{hours} h {minutes:02} min' if hours else f'{minutes} min {rest:02} s'


def _has_ended(job: JobStatus) -> bool:
    return job.state in OVER


# --- commands -------------------------------------------------------------------------------


def _add(args: argparse.Namespace) -> int:
    if not args.what:
        raise WrongUse('queue add: name at least one order')
    from bt_orchestrator_interfaces.srv import QueueAdd

    request = add_request([Path(name) for name in args.what])
    request.position, request.held = args.at, args.held
    return show_orders(_call(args, QueueAdd, 'add', request), as_json=args.json)


def _move(args: argparse.Namespace) -> int:
    job, place = _expect(args, 2, 'a job and its place')
    try:
        position = whole_32(place)
    except argparse.ArgumentTypeError as error:
        raise WrongUse(f'queue move: the place: {error}') from None
    from bt_orchestrator_interfaces.srv import QueueMove

    return _ask(args, QueueMove, 'move', job=job, position=position)


def _update(args: argparse.Namespace) -> int:
    (job,) = _expect(args, 1, 'one job')
    params = dict(_pair(text) for text in args.param)
    terms = changed_terms(args)
    if not (params or args.quantity or args.script or terms):
        raise WrongUse(
            'queue update: say what to change: --quantity, --param, --script, --priority, '
            '--start, --due or --details'
        )
    from bt_orchestrator_interfaces.srv import QueueUpdate

    changes = {
        'quantity': args.quantity,
        'script': script_name(args.script),
        'params': key_values(params),
        **terms,
    }
    return _ask(args, QueueUpdate, 'update', job=job, **changes)


def _stop_after(args: argparse.Namespace) -> int:
    (after,) = _expect(args, 1, 'one of item, job, never')
    if after not in AFTER:
        raise WrongUse(f'queue stop-after: one of {", ".join(AFTER)}; found {after!r}')
    from bt_orchestrator_interfaces.srv import QueueStopAfter

    return _ask(args, QueueStopAfter, 'stop_after', after=after)


def _control(args: argparse.Namespace) -> int:
    (job,) = _expect(args, 1, 'one job')
    from bt_orchestrator_interfaces.srv import QueueCommand

    return _ask(args, QueueCommand, 'command', command=args.action, job=job)


_ASK: Mapping[str, Callable[[argparse.Namespace], int]] = {
    'add': _add,
    'move': _move,
    'update': _update,
    'stop-after': _stop_after,
}


def _expect(args: argparse.Namespace, count: int, what: str) -> list[str]:
    if len(args.what) != count:
        found = ' '.join(args.what) or 'nothing'
        raise WrongUse(f'queue {args.action}: expected {what}, found {found}')
    return list(args.what)


def _pair(text: str) -> tuple[str, str]:
    name, equals, value = text.partition('=')
    if not name or not equals:
        raise WrongUse(f'queue update: --param is NAME=VALUE; found {text!r}')
    return name, value


def _call(args: argparse.Namespace, kind: Any, service: str, request: Any) -> Any:
    from bt_orchestrator.ros.link.client import NodeClient

    request.who, request.origin, request.reason = args.who, origin(), args.reason or ''
    with NodeClient(args.node, args.timeout) as client:
        return client.call(kind, f'queue/{service}', request)


def _ask(args: argparse.Namespace, kind: Any, service: str, **fields: Any) -> int:
    response = _call(args, kind, service, kind.Request(**fields))
    findings = list(getattr(response, 'findings', ()))
    if args.json:
        plain = {'accepted': response.accepted, 'message': response.message}
        print(json.dumps({**plain, 'findings': findings}))
    else:
        stream = sys.stdout if response.accepted else sys.stderr
        print('\n'.join([response.message, *findings]), file=stream)
    return 0 if response.accepted else 1
