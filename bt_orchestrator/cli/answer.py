"""The verb `answer`: decide about a hold."""

from __future__ import annotations

import argparse

from bt_orchestrator.cli.asked_verbs import in_one_line
from bt_orchestrator.cli.door import ask_and_print
from bt_orchestrator.cli.node_options import add_node_options, add_who_options
from bt_orchestrator.cli.wrong_use import WrongUse
from bt_orchestrator.model.requests import ACKNOWLEDGE, ANSWERS, COMMENT
from bt_orchestrator.script.given_results import results_of

DESCRIPTION = """\
Decide about something that is held; `status` lists the holds and what each of them offers.
"""

WORDS = {**ANSWERS, **{one.word: one for one in (ACKNOWLEDGE, COMMENT)}}
"""Answers, and remarks, which leave the hold as it is."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    each = [f'  {word:<11} {in_one_line(request)}' for word, request in WORDS.items()]
    parser.description = '\n'.join([DESCRIPTION, *each])
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument('hold', metavar='HOLD', help='id of the hold')
    parser.add_argument('answer', choices=tuple(WORDS), help='the decision, or a remark')
    parser.add_argument(
        '--result',
        action='append',
        default=[],
        metavar='FIELD=VALUE',
        help='with mark_done: a result field of the task, for later tasks that refer to it, as in '
        'measurement=3.5, pose.x=1.0 or values="[1, 2]"; may be repeated',
    )
    add_who_options(parser)
    add_node_options(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns 1 when the answer was refused."""
    try:
        results = results_of(args.result) or None
    except ValueError as error:
        raise WrongUse(f'answer: {error}') from error
    return ask_and_print(args, f'hold.{args.answer}', hold=args.hold, results=results)
