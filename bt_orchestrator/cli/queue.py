"""The verb `queue`: list the jobs of a running node, and change what is done when."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, Protocol

from bt_orchestrator.cli.asked_verbs import in_one_line
from bt_orchestrator.cli.door import ask_and_print, open_door
from bt_orchestrator.cli.node_options import add_node_options, add_who_options
from bt_orchestrator.cli.numbers import whole_32
from bt_orchestrator.cli.ordering.order_request import give_orders, script_name
from bt_orchestrator.cli.ordering.order_terms import (
    add_recipe_options,
    add_term_options,
    changed_recipe,
    changed_terms,
    pair,
)
from bt_orchestrator.cli.wrong_use import WrongUse
from bt_orchestrator.errors import CommandRefused
from bt_orchestrator.model.codec import to_plain
from bt_orchestrator.model.frozen import changed
from bt_orchestrator.model.jobs.isa95 import OVER
from bt_orchestrator.model.requests import (
    ADD,
    COMMANDED,
    MOVE,
    REQUEUE,
    STOP_AFTERS,
    UPDATE,
    About,
    Request,
    of_word,
)
from bt_orchestrator.model.status import CellStatus, JobStatus
from bt_orchestrator.model.status_words import script_words
from bt_orchestrator.ports import QueuePage
from bt_orchestrator.screen.words import job_terms

STOP_AFTER = 'stop-after'

DESCRIPTION = """\
List and change the queue of a running tree node. Without an action: the jobs on the line, then the
queue in order. After each action is who may ask for it (docs/security.md).
"""


def description() -> str:
    """Return what can be done, from the table of requests."""
    rows = [
        ('add ORDER...', f'{in_one_line(ADD)}; --at N, --held'),
        ('move JOB N', in_one_line(MOVE)),
        ('update JOB', f'{in_one_line(UPDATE)}; --quantity, --param NAME=VALUE, --script, ...'),
        *((f'{word} JOB', in_one_line(_control_of(word))) for word in COMMANDED),
        *((f'{STOP_AFTER} {after}', in_one_line(one)) for after, one in STOP_AFTERS.items()),
    ]
    return '\n'.join([DESCRIPTION, *(f'  queue {what:<17} {does}' for what, does in rows)])


def _control_of(word: str) -> Request:
    request = of_word(About.JOB, word)
    assert request is not None
    return request


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = description()
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    actions = ('list', ADD.word, MOVE.word, UPDATE.word, *COMMANDED, STOP_AFTER)
    parser.add_argument(
        'action', nargs='?', default='list', choices=actions, help='what to do (default: list)'
    )
    parser.add_argument('what', nargs='*', metavar='WHAT', help='orders, a job, a place')
    parser.add_argument('--at', type=whole_32, default=0, metavar='N', help='add: place, from 1')
    parser.add_argument('--held', action='store_true', help='add: keep them from starting')
    parser.add_argument(
        '--as', dest='order', default='', metavar='ID', help='requeue: id of the new order'
    )
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
    add_recipe_options(parser)
    add_term_options(parser)
    parser.add_argument('--json', action='store_true', help='print JSON')
    add_who_options(parser, required=False)
    add_node_options(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns 1 when it was refused."""
    _refuse_options_of_others(args)
    if args.action == 'list':
        _expect(args, 0, 'nothing')
        return _list(args)
    if args.action != ADD.word and not args.reason:
        raise WrongUse(f'queue {args.action}: say why, with --reason TEXT')
    ask = _ASK.get(args.action, _control)
    return ask(args)


_OPTIONS = {
    'at': ADD.word,
    'held': ADD.word,
    'order': REQUEUE.word,
    **dict.fromkeys(('quantity', 'param', 'script', 'recipe', 'version', 'bind'), UPDATE.word),
    **dict.fromkeys(('priority', 'start', 'due', 'details'), UPDATE.word),
}
"""Options of one action alone, by their names in the arguments."""


def _refuse_options_of_others(args: argparse.Namespace) -> None:
    for name, action in _OPTIONS.items():
        value = getattr(args, name)
        is_given = value is not None if name == 'priority' else bool(value)
        if is_given and action != args.action:
            option = 'as' if name == 'order' else name
            raise WrongUse(f'queue {args.action}: --{option} is for queue {action}')


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
    """What of `ports.CellLink` tells the queue."""

    def queue(self, after: str = '', most: int = 0) -> QueuePage: ...


def others(door: _Queue, status: CellStatus) -> list[JobStatus]:
    """Return the jobs of the queue that a status does not list."""
    listed = [job.id for job in status.jobs if job.position]
    if status.queued <= len(listed):
        return []
    known, after = set(listed), listed[-1]
    found: list[JobStatus] = []
    while True:
        try:
            page = door.queue(after)
        except CommandRefused:
            # What began behind a job that has left the queue meanwhile, begins with the first one.
            page = door.queue(after := '')
        if not page.jobs:
            return found
        after = page.jobs[-1].id
        found += [job for job in page.jobs if job.id not in known]
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


# --- commands -------------------------------------------------------------------------------


def _add(args: argparse.Namespace) -> int:
    if not args.what:
        raise WrongUse('queue add: name at least one order')
    files = [Path(name) for name in args.what]
    return give_orders(args, files, position=args.at or None, held=args.held)


def _move(args: argparse.Namespace) -> int:
    job, place = _expect(args, 2, 'a job and its place')
    try:
        position = whole_32(place)
    except argparse.ArgumentTypeError as error:
        raise WrongUse(f'queue move: the place: {error}') from None
    return _ask(args, 'job.move', job=job, position=position)


def _update(args: argparse.Namespace) -> int:
    (job,) = _expect(args, 1, 'one job')
    params = dict(pair('--param', text) for text in args.param)
    terms = {**changed_terms(args), **changed_recipe(args)}
    if not (params or args.quantity or args.script or terms):
        raise WrongUse(
            'queue update: say what to change: --quantity, --param, --script, --recipe, '
            '--version, --bind, --priority, --start, --due or --details'
        )
    changes = {
        'quantity': args.quantity or None,
        'script': script_name(args.script) or None,
        'params': params or None,
        **terms,
    }
    return _ask(args, 'job.update', job=job, **changes)


def _stop_after(args: argparse.Namespace) -> int:
    (after,) = _expect(args, 1, f'one of {", ".join(STOP_AFTERS)}')
    if after not in STOP_AFTERS:
        raise WrongUse(f'queue stop-after: one of {", ".join(STOP_AFTERS)}; found {after!r}')
    return _ask(args, STOP_AFTERS[after].name)


def _control(args: argparse.Namespace) -> int:
    (job,) = _expect(args, 1, 'one job')
    request = _control_of(args.action)
    given = {'order': args.order or None} if request == REQUEUE else {}
    return _ask(args, request.name, job=job, **given)


_ASK: Mapping[str, Callable[[argparse.Namespace], int]] = {
    ADD.word: _add,
    MOVE.word: _move,
    UPDATE.word: _update,
    STOP_AFTER: _stop_after,
}


def _expect(args: argparse.Namespace, count: int, what: str) -> list[str]:
    if len(args.what) != count:
        found = ' '.join(args.what) or 'nothing'
        raise WrongUse(f'queue {args.action}: expected {what}, found {found}')
    return list(args.what)


def _ask(args: argparse.Namespace, name: str, **given: Any) -> int:
    return ask_and_print(args, name, as_json=args.json, **given)
