"""Priority, start, due and details of an order on the command line."""

from __future__ import annotations

import argparse
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bt_orchestrator.cli.numbers import whole_32
from bt_orchestrator.cli.wrong_use import WrongUse
from bt_orchestrator.model.jobs.order import Terms
from bt_orchestrator.ordinary_file import read_ordinary
from bt_orchestrator.script.field_types import Misfit
from bt_orchestrator.script.instants import instant
from bt_orchestrator.script.orders.asked import NONE
from bt_orchestrator.script.orders.terms import Wrong, details_of, wrong_terms
from bt_orchestrator.script.script_keys import ORDER

LARGEST_FILE = 1_000_000
"""Bytes of a file with details; the node takes fewer."""


def add_term_options(parser: argparse.ArgumentParser) -> None:
    """Declare the options with which a queued job is changed."""
    parser.add_argument(
        '--priority', type=_priority, metavar='N', help='update: the higher the more urgent'
    )
    for name, meaning in (('start', 'may begin'), ('due', 'should have ended')):
        parser.add_argument(
            f'--{name}',
            type=_moment,
            metavar='TIME',
            help=f'update: when it {meaning}, with time zone, or {NONE}',
        )
    parser.add_argument(
        '--details',
        default='',
        metavar='FILE|JSON',
        help=f'update: a JSON object, or a file with one, or {NONE}',
    )


def changed_terms(args: argparse.Namespace) -> dict[str, Any]:
    """Return the arguments of the request job.update that were said."""
    details = _details(args.details) if args.details else None
    said = {
        'priority': args.priority,
        'start': args.start,
        'due': args.due,
        'details': details,
    }
    return {name: value for name, value in said.items() if value is not None}


def _priority(text: str) -> int:
    key = ORDER.by_name['priority']
    assert key.minimum is not None
    assert key.maximum is not None
    is_whole = re.fullmatch('[-+]?[0-9]{1,9}', text) is not None
    if not is_whole or not key.minimum <= int(text) <= key.maximum:
        raise argparse.ArgumentTypeError(
            f'expected a whole number from {key.minimum} to {key.maximum}, found {text!r}'
        )
    return int(text)


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
        what = f'--details is a JSON object or a file with one; {text!r} is none: {error}'
        raise WrongUse(f'queue update: {what}') from None
    details = details_of(written)
    wrong = details if isinstance(details, Wrong) else _first_mistake(Terms(details=details))
    if wrong is not None:
        raise WrongUse(f'queue update: {wrong.what}; {wrong.hint}')
    assert not isinstance(details, Wrong)
    return details


def _text_of(path: Path) -> str:
    return read_ordinary(path, LARGEST_FILE).decode('utf-8')


def _first_mistake(terms: Terms) -> Wrong | None:
    return next(wrong_terms(terms), None)


def add_recipe_options(parser: argparse.ArgumentParser) -> None:
    """Declare the recipe of a queued job."""
    parser.add_argument(
        '--recipe',
        action='append',
        default=[],
        metavar='RECIPE',
        help='update: recipe in place of a script; repeated: the first that can be made',
    )
    parser.add_argument(
        '--version', type=whole_32, metavar='N', help='update: version of the recipe'
    )
    parser.add_argument(
        '--bind',
        action='append',
        default=[],
        metavar='OPERATION=COMPONENT',
        help='update: who does an operation of the recipe; may be given several times',
    )


def changed_recipe(args: argparse.Namespace) -> dict[str, Any]:
    """Return the arguments of job.update that name a recipe."""
    given = {
        'recipe': args.recipe,
        'version': args.version,
        'bind': dict(pair('--bind', text) for text in args.bind),
    }
    return {key: value for key, value in given.items() if value}


def pair(option: str, text: str) -> tuple[str, str]:
    """Return name and value of an option of `queue update`.

    :raises WrongUse: it has not both
    """
    name, equals, value = text.partition('=')
    if not name or not equals:
        raise WrongUse(f'queue update: {option} is NAME=VALUE; found {text!r}')
    return name, value
