"""The verb `cell`: commands to the cell as a whole."""

from __future__ import annotations

import argparse
from collections.abc import Mapping

from bt_orchestrator.cli.action import Action
from bt_orchestrator.cli.asked.derived import add_answer_options, of_request
from bt_orchestrator.cli.asked.words import allowed, in_one_line
from bt_orchestrator.cli.door import ask_and_print
from bt_orchestrator.model.requests import CELL, STOP_AFTERS

DESCRIPTION = """\
Command the cell of a running tree node as a whole; `job` is for one job. docs/operating.md says
what each command does in which state. The node refuses a command that is not possible now, and
names those that are."""

_ANY = next(iter(STOP_AFTERS.values()))


def _add_stop_after(parser: argparse.ArgumentParser) -> None:
    each = (f'{after}: {in_one_line(one)}' for after, one in STOP_AFTERS.items())
    parser.description = '; '.join(each)
    parser.add_argument('after', choices=tuple(STOP_AFTERS), help='after what')
    add_answer_options(parser, _ANY)


def _stop_after(args: argparse.Namespace) -> int:
    return ask_and_print(args, STOP_AFTERS[args.after].name, as_json=args.json)


ACTIONS: Mapping[str, Action] = {
    **{one.word: of_request(one) for one in CELL.values()},
    'stop-after': Action(
        _add_stop_after,
        _stop_after,
        f'lets the line run empty after an item or a job, then stops ({allowed(_ANY)})',
    ),
}
