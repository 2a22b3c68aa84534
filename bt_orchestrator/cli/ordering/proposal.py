"""`queue propose`: an order of the queue, what it leads to, and how sure that is."""

from __future__ import annotations

import argparse
import contextlib
import json
import shlex
from collections.abc import Iterator

from bt_orchestrator.base.errors import counted
from bt_orchestrator.cli.command_parser import allowed
from bt_orchestrator.cli.door import ask_and_print, open_door
from bt_orchestrator.cli.node_options import add_node_options, add_who_options
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.cli.processes.planning_process import PlanningProcess
from bt_orchestrator.model.limits import QUEUE_SHOWN
from bt_orchestrator.model.requests import REQUESTS
from bt_orchestrator.ports import Proposal, ProposedJob
from bt_orchestrator.view.report.tables import table
from bt_orchestrator.view.screen.advice import WHY, Shell

ARRANGE = REQUESTS['queue.arrange']

DESCRIPTION = f"""\
Propose an order of the queue: by priority, then by the lateness of all jobs in total. Equally late
orders are compared by the time of changes of setups, then by the present places. Places that a
person chose stay, and so do jobs that may not start. Ends are those of the engine in virtual time,
as in `what-if`. Nothing is asked of the cell without --apply.
One request applies it, {ARRANGE.name} ({allowed(ARRANGE)}). It is refused if the queue has
changed since."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.description = DESCRIPTION
    parser.add_argument('--apply', action='store_true', help='put the queue into that order')
    parser.add_argument('--json', action='store_true', help='one JSON object; then the answer')
    add_who_options(parser, required=False)
    add_node_options(parser)


def run(args: argparse.Namespace) -> int:
    """Propose an order; returns 1 if it was to be applied, and was refused."""
    if args.apply and not args.reason:
        raise WrongUse('queue propose --apply: say why, with --reason TEXT')
    with open_door(args.node, args.timeout) as door:
        moment = door.moment()
        left_out = max(0, door.queue(most=1).queued - QUEUE_SHOWN)
    with contextlib.closing(PlanningProcess()) as planning:
        proposal = planning.propose(moment)
    if args.json:
        print(json.dumps({**_plain(proposal), 'left_out': left_out}))
    else:
        print('\n'.join(lines(proposal, moment.now_s, left_out)), flush=True)
    request = {'jobs': list(proposal.order), 'queue_digest': proposal.queue_digest}
    if args.apply and proposal.is_new:
        return ask_and_print(args, ARRANGE.name, as_json=args.json, **request)
    if proposal.is_new and not args.json:
        words = f'queue arrange {shlex.join([proposal.queue_digest, *proposal.order])} {WHY}'
        print(f'to apply it: {Shell(args.node).command(words)}')
    return 0


def lines(proposal: Proposal, now_s: float, left_out: int = 0) -> Iterator[str]:
    """Yield a proposal as text.

    :param now_s: the moment that it is for
    :param left_out: how many jobs at the end of the queue are not in it
    """
    headers = ('job', 'place', 'now', 'priority', 'due in', 'would end in', 'now', 'late', 'now')
    yield from table(headers, [_row(job, now_s) for job in proposal.jobs])
    yield f'all jobs together: {proposal.new_late_s:.1f} s late; now {proposal.late_s:.1f} s'
    if proposal.changeover_s or proposal.new_changeover_s:
        yield (
            f'changes of setups: {proposal.new_changeover_s:.1f} s; '
            f'now {proposal.changeover_s:.1f} s'
        )
    yield how_sure(proposal)
    if not proposal.is_new:
        yield 'the queue stays unchanged'
    yield from (f'{job.job} stays: {job.stays}' for job in proposal.jobs if job.stays)
    yield from (f'{job}: the end is unknown, {why}' for job, why in proposal.unknown.items())
    if left_out:
        yield f'without the last {counted(left_out, "job")} of the queue, which keep their places'


def how_sure(proposal: Proposal) -> str:
    """Say what is known of better orders."""
    which = 'that keep priorities and the places that stay'
    if proposal.orders == 1:
        return f'it is the only order {which}'
    if proposal.is_best:
        return f'it is the best of all {proposal.orders} orders {which}'
    looked_at = counted(proposal.looked_at, 'order')
    return f'it is the best of {looked_at} looked at, of {proposal.orders} {which}'


def _row(job: ProposedJob, now_s: float) -> tuple[str, ...]:
    due_s = None if job.due is None else job.due - now_s
    return (
        job.job,
        *(str(place) if place else 'line' for place in (job.new_place, job.place)),
        str(job.priority),
        '' if due_s is None else f'{due_s:.1f} s',
        *('unknown' if ends is None else f'{ends:.1f} s' for ends in (job.new_ends_s, job.ends_s)),
        *(_late(ends, due_s) for ends in (job.new_ends_s, job.ends_s)),
    )


def _late(ends_s: float | None, due_s: float | None) -> str:
    if ends_s is None or due_s is None or ends_s <= due_s:
        return ''
    return f'{ends_s - due_s:.1f} s'


def _plain(proposal: Proposal) -> dict[str, object]:
    """Return what JSON can carry."""
    return {
        **proposal._asdict(),
        'jobs': [job._asdict() for job in proposal.jobs],
        'order': list(proposal.order),
        'is_new': proposal.is_new,
        'unknown': dict(proposal.unknown),
    }
