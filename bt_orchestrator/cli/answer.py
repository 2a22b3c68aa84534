"""The verb `answer`: decide about a hold."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from bt_orchestrator.cli.command_parser import in_one_line
from bt_orchestrator.cli.door import ask_and_print, asked, door_for
from bt_orchestrator.cli.node_options import add_node_options, add_who_options
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.model.requests import About, requests_about
from bt_orchestrator.model.requests.offers import why_singly
from bt_orchestrator.model.state import Hold
from bt_orchestrator.ports import CellLink
from bt_orchestrator.script.given_values import results_of

DESCRIPTION = """\
Decide about something that is held; `status` lists the holds and what each of them offers.
"""

WORDS = {request.word: request for request in requests_about(About.HOLD)}
"""Answers, and remarks, which leave the hold unchanged."""

_CODE = next(
    parameter
    for word in WORDS.values()
    for parameter in word.parameters
    if parameter.name == 'code'
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    each = [f'  {word:<11} {in_one_line(request)}' for word, request in WORDS.items()]
    parser.description = '\n'.join([DESCRIPTION, *each])
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument(
        'hold',
        metavar='HOLD',
        help='id of the hold; several that are alike as a list, 3,4,7: each answer is sent and '
        'recorded by itself',
    )
    parser.add_argument('answer', choices=tuple(WORDS), help='the decision, or a remark')
    parser.add_argument(
        '--result',
        action='append',
        default=[],
        metavar='FIELD=VALUE',
        help='with mark_done: a result field of the task, for later tasks that refer to it, as in '
        'measurement=3.5, pose.x=1.0 or values="[1, 2]"; may be repeated',
    )
    parser.add_argument('--code', metavar='CODE', help=f'{_CODE.meaning}; not with a remark')
    add_who_options(parser)
    add_node_options(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns 1 when the answer was refused."""
    try:
        results = results_of(args.result) or None
    except ValueError as error:
        raise WrongUse(f'answer: {error}') from error
    if args.code and WORDS[args.answer].is_remark:
        raise WrongUse('answer: a remark has no reason of the plant; leave --code out')
    holds = list(dict.fromkeys(filter(None, args.hold.split(','))))
    if len(holds) < 2:
        given = {'hold': args.hold, 'results': results, 'code': args.code}
        return ask_and_print(args, f'hold.{args.answer}', **given)
    if results:
        raise WrongUse('answer: results belong to one task; answer its hold singly')
    return _answer_each(args, holds)


def _answer_each(args: argparse.Namespace, holds: Sequence[str]) -> int:
    """Send the same answer to several holds, if a list may carry it to each of them."""
    with door_for(args) as door:
        there = {hold.id: hold for hold in door.status().holds}
        wrong = [_why_not(there.get(name), name, args.answer) for name in holds]
        if any(wrong):
            print('\n'.join([*filter(None, wrong), 'nothing was answered']), file=sys.stderr)
            return 1
        return max(_send(args, door, name) for name in holds)


def _why_not(hold: Hold | None, name: str, answer: str) -> str:
    return f'there is no hold {name}' if hold is None else why_singly(hold, answer)


def _send(args: argparse.Namespace, door: CellLink, hold: str) -> int:
    answer = door.ask(asked(args, f'hold.{args.answer}', hold=hold, code=args.code))
    print(f'hold {hold}: {answer.message}', file=sys.stdout if answer.accepted else sys.stderr)
    return 0 if answer.accepted else 1
