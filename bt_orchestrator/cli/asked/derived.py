"""An action of the command line, derived from the declaration of its request."""

from __future__ import annotations

import argparse
import re
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from bt_orchestrator.base.ordinary_file import read_ordinary
from bt_orchestrator.cli.command_parser import Action, in_one_line, what_to_know
from bt_orchestrator.cli.door import ask_and_print
from bt_orchestrator.cli.node_options import add_node_options, add_who_options
from bt_orchestrator.cli.ordering.order_request import script_name
from bt_orchestrator.model.jobs.order import Terms
from bt_orchestrator.model.requests import (
    About,
    Kind,
    Parameter,
    Request,
    Why,
    of_word,
    words_about,
)
from bt_orchestrator.model.stop_reason import NAMED
from bt_orchestrator.script.field_types import Misfit
from bt_orchestrator.script.orders.asked import NONE
from bt_orchestrator.script.orders.instants import instant
from bt_orchestrator.script.orders.terms import Wrong, details_of, wrong_terms

LARGEST_FILE = 1_000_000
"""Bytes of a file with details; the node takes fewer."""


def one_word(name: str) -> str:
    """Return a name as it is typed, for instance remove-item."""
    return name.replace('_', '-')


def _pair(text: str) -> tuple[str, str]:
    name, equals, value = text.partition('=')
    if not name or not equals:
        raise argparse.ArgumentTypeError(f'expected NAME=VALUE, found {text!r}')
    return name, value


def _moment(text: str) -> str:
    """Return a time as it was written, or `none`."""
    time = None if text == NONE else instant(text)
    if isinstance(time, Misfit):
        raise argparse.ArgumentTypeError(f'expected {time.needed}, found {text!r}; {time.hint}')
    return text


def _details(text: str) -> Mapping[str, object]:
    if text == NONE:
        return {}
    try:
        written = text if text.lstrip().startswith('{') else _text_of(Path(text))
    except (OSError, ValueError) as error:
        raise argparse.ArgumentTypeError(
            f'expected a JSON object or a file with one, found {text!r}: {error}'
        ) from None
    details = details_of(written)
    wrong = details if isinstance(details, Wrong) else _first_mistake(Terms(details=details))
    if wrong is not None:
        raise argparse.ArgumentTypeError(f'{wrong.what}; {wrong.hint}')
    assert not isinstance(details, Wrong)
    return details


def _text_of(path: Path) -> str:
    return read_ordinary(path, LARGEST_FILE).decode('utf-8')


def _first_mistake(terms: Terms) -> Wrong | None:
    return next(wrong_terms(terms), None)


def _slots(text: str) -> list[str]:
    return re.split(r',(?=\s*\d+\s*=)', text)  # a comma may be part of an order's id


def _several(type_: Any, metavar: str) -> dict[str, Any]:
    return {'action': 'append', 'type': type_, 'metavar': metavar}


_BELT = {'type': _slots, 'metavar': 'SLOTS', 'help': 'every slot, as in 1=WO-1/3,2=empty'}

TYPED: Mapping[str, tuple[str, Mapping[str, Any]]] = {
    'cell.resume.hold': ('', {'metavar': 'N'}),
    'cell.resume.everyones': ('--all', {}),
    'cell.clear.as_shown': ('', {'metavar': 'SEQ'}),
    'cell.clear.belt': ('', _BELT),
    'cell.production.as_shown': ('', {'metavar': 'SEQ'}),
    'cell.production.belt': ('', _BELT),
    'component.run_task.args': ('--arg', _several(str, 'FIELD=VALUE')),
    'component.run_task.hold': ('', {'metavar': 'N'}),
    'queue.arrange.queue_digest': ('', {'metavar': 'DIGEST'}),
    'queue.arrange.jobs': ('', {'nargs': '+', 'metavar': 'JOB'}),
    'job.move.position': ('', {'metavar': 'N'}),
    'job.requeue.order': ('--as', {'metavar': 'ID'}),
    'job.update.quantity': ('', {'metavar': 'N'}),
    'job.update.params': ('--param', _several(_pair, 'NAME=VALUE')),
    'job.update.script': ('', {'type': script_name}),
    'job.update.recipe': ('', _several(str, 'RECIPE')),
    'job.update.version': ('', {'metavar': 'N'}),
    'job.update.bind': ('', _several(_pair, 'OPERATION=COMPONENT')),
    'job.update.priority': ('', {'metavar': 'N'}),
    'job.update.start': ('', {'type': _moment, 'metavar': 'TIME'}),
    'job.update.due': ('', {'type': _moment, 'metavar': 'TIME'}),
    'job.update.details': ('', {'type': _details, 'metavar': 'FILE|JSON'}),
}
"""Option, if it has another name, and settings for argparse, by request and parameter."""


_NO_LOCKOUT = (
    'It does not protect people at the machine: lock out its energy before you reach into it.'
)

_MORE: Mapping[str, str] = {
    'cell.clear': 'Look at the belt and at `status`. If they agree, name the seq that `status` '
    'prints; it is refused if the belt has changed since. Otherwise name what stands in every '
    'slot. An item that is not there any more is taken out. Any other difference is refused, '
    'with what to do about it.',
    'cell.manual': 'The line has to be in local, and without items. You send goals with '
    '`component run-task`, and leave manual mode with `cell production`.',
    'cell.production': 'State the belt as with `clear`.',
    'cell.resume': 'Without an option it releases your own pauses. The cell goes on when no pause '
    f'and no other hold is left. The holds {", ".join(sorted(NAMED))} ask somebody to look at the '
    'line first: each is released only by --hold.',
    'component.out_of_service': _NO_LOCKOUT,
    'component.in_service': _NO_LOCKOUT,
    'script.release_script': 'The release is for the cell file that the node runs with. Read the '
    'script before. `generate ... --release` generates a script and releases it.',
}
"""More that a user should know, besides the declaration."""

_EITHER = {'cell.clear': True, 'cell.production': True, 'cell.resume': False}
"""Requests with parameters that exclude each other, and whether one is needed."""


def actions_about(about: About) -> dict[str, Action]:
    """Return the action of each word that is asked of a subject."""
    actions = {}
    for word in words_about(about):
        request = of_word(about, word)
        assert request is not None
        action = of_request(request)
        same = action._replace(effect=f'the same as {request.word}')
        actions[one_word(word)] = action if word == request.word else same
    return actions


def of_request(request: Request) -> Action:
    """Return what a user types for a request."""
    declare, run = partial(_declare, request), partial(run_request, request)
    return Action(declare, run, in_one_line(request))


def _declare(request: Request, parser: argparse.ArgumentParser) -> None:
    parser.description = ' '.join([what_to_know(request), _MORE.get(request.name, '')]).strip()
    options: argparse._ActionsContainer = parser
    if request.name in _EITHER:
        options = parser.add_mutually_exclusive_group(required=_EITHER[request.name])
    for parameter in request.parameters:
        flag, settings = TYPED.get(f'{request.name}.{parameter.name}', ('', {}))
        settings = {'help': parameter.meaning, **_by_kind(parameter), **settings}
        if parameter.is_required:
            parser.add_argument(parameter.name, **settings)
        else:
            options.add_argument(
                flag or f'--{one_word(parameter.name)}', dest=parameter.name, **settings
            )
    add_answer_options(parser, request)


def add_answer_options(parser: argparse.ArgumentParser, request: Request) -> None:
    """Declare who asks which node, and how the answer is printed."""
    parser.add_argument('--json', action='store_true', help='print the answer as JSON')
    add_who_options(parser, required=request.why is Why.FIRST)
    add_node_options(parser)


def _by_kind(parameter: Parameter) -> dict[str, Any]:
    name = one_word(parameter.name).upper()
    if parameter.kind is Kind.YES_NO:
        return {'action': 'store_true'}
    return {
        'metavar': name,
        **({'type': _whole(parameter)} if parameter.kind is Kind.WHOLE else {}),
    }


def _whole(parameter: Parameter) -> Any:
    low, high = parameter.span

    def whole(text: str) -> int:
        digits = text.removeprefix('-') if low < 0 else text
        is_number = digits.isascii() and digits.isdecimal() and len(digits) < 21
        if not is_number or not low <= int(text) <= high:
            wanted = f'expected a whole number from {low} to {high}'
            raise argparse.ArgumentTypeError(f'{wanted}, found {text!r}')
        return int(text)

    return whole


def run_request(request: Request, args: argparse.Namespace) -> int:
    """Ask what was typed; returns 1 when it was refused."""
    return ask_and_print(args, request.name, as_json=args.json, **given(request, args))


def given(request: Request, args: argparse.Namespace) -> dict[str, Any]:
    """Return the arguments of a request that were typed."""
    values = {parameter: getattr(args, parameter.name) for parameter in request.parameters}
    typed = {
        parameter: value for parameter, value in values.items() if not _is_none(parameter, value)
    }
    return {
        parameter.name: dict(value) if parameter.kind is Kind.VALUES else value
        for parameter, value in typed.items()
    }


def _is_none(parameter: Parameter, value: object) -> bool:
    """Tell whether nothing is meant: 0 is none where numbers begin with it."""
    return value is None or (
        value in (0, '') and not parameter.is_required and parameter.span[0] == 0
    )
