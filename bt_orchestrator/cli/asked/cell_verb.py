"""The verb `cell`: commands to the cell as a whole."""

from __future__ import annotations

import argparse
from collections.abc import Mapping

from bt_orchestrator.cli.asked.derived import add_answer_options, of_request, one_word
from bt_orchestrator.cli.command_parser import Action, allowed, in_one_line
from bt_orchestrator.cli.door import ask_and_print
from bt_orchestrator.model.requests import About, requests_about
from bt_orchestrator.model.stop_reason import STOP_AFTER

DESCRIPTION = """\
Command the cell of a running tree node as a whole; `job` is for one job. docs/operating.md says
what each command does in which state. The node refuses a command that is not possible now, and
names those that are."""

_OF_CELL = requests_about(About.CELL)
_STOP_AFTERS = [request for request in _OF_CELL if request.word.startswith(STOP_AFTER)]


def _add_stop_after(parser: argparse.ArgumentParser) -> None:
    words = [request.word.removeprefix(STOP_AFTER) for request in _STOP_AFTERS]
    each = map('{}: {}'.format, words, map(in_one_line, _STOP_AFTERS))
    parser.description = '. '.join(each)
    parser.add_argument('after', choices=words, help='after what')
    add_answer_options(parser, _STOP_AFTERS[0])


def _stop_after(args: argparse.Namespace) -> int:
    return ask_and_print(args, f'cell.{STOP_AFTER}{args.after}', as_json=args.json)


ACTIONS: Mapping[str, Action] = {
    **{
        one_word(request.word): of_request(request)
        for request in _OF_CELL
        if request not in _STOP_AFTERS
    },
    'stop-after': Action(
        _add_stop_after,
        _stop_after,
        f'lets the line run empty after an item or a job, then stops ({allowed(_STOP_AFTERS[0])})',
    ),
}
