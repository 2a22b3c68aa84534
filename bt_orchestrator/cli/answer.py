"""The verb `answer`: decide about a hold."""

from __future__ import annotations

import argparse

from bt_orchestrator.cli.node_options import add_node_options, add_who_options, call_and_print

ANSWERS = ('retry', 'mark_done', 'skip', 'reject', 'abort_job')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = 'Decide about something that is held; `status` lists the holds.'
    parser.add_argument('hold', metavar='HOLD', help='id of the hold')
    parser.add_argument('answer', choices=ANSWERS, help='the decision')
    add_who_options(parser)
    add_node_options(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns 1 when the answer was refused."""
    from bt_orchestrator_interfaces.srv import AnswerHold

    request = AnswerHold.Request(
        hold=args.hold, answer=args.answer, who=args.who, reason=args.reason
    )
    return call_and_print(args, AnswerHold, 'answer_hold', request)
