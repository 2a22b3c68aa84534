"""Priority, start, due and details of an order on the command line, as fields of requests."""

from __future__ import annotations

import argparse
import re
from pathlib import Path
from typing import Any

from bt_orchestrator.cli.wrong_use import WrongUse
from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.jobs.order import Terms
from bt_orchestrator.script.field_types import Misfit
from bt_orchestrator.script.instants import instant
from bt_orchestrator.script.orders.terms import Wrong, details_of, wrong_terms
from bt_orchestrator.script.script_keys import ORDER

NONE = 'none'
"""What is written where a job is to have none any more."""


def add_term_options(parser: argparse.ArgumentParser) -> None:
    """Declare the options with which a queued job is changed."""
    parser.add_argument(
        '--priority', type=_priority, metavar='N', help='update: the higher the more urgent'
    )
    for name, meaning in (('start', 'begin'), ('due', 'have ended')):
        parser.add_argument(
            f'--{name}',
            type=_moment,
            metavar='TIME',
            help=f'update: when it should {meaning}, with time zone, or {NONE}',
        )
    parser.add_argument(
        '--details',
        default='',
        metavar='FILE|JSON',
        help=f'update: a JSON object, or a file with one, or {NONE}',
    )


def changed_terms(args: argparse.Namespace) -> dict[str, Any]:
    """Return the fields of a change (srv/QueueUpdate) that were asked for."""
    from bt_orchestrator.ros.stamps import to_time

    fields: dict[str, Any] = {}
    if args.priority is not None:
        fields['priority'] = [args.priority]
    for name in ('start', 'due'):
        time = getattr(args, name)
        if time is not None:
            fields[name] = [to_time(time)]
    if args.details:
        fields['details'] = _details(args.details)
    return fields


def given_terms(terms: Terms) -> dict[str, Any]:
    """Return the fields of an order (msg/WorkOrder)."""
    from bt_orchestrator.ros.stamps import to_moment

    return {
        'priority': terms.priority,
        'start': to_moment(terms.start),
        'due': to_moment(terms.due),
        'details': json_of(terms.details) if terms.details else '',
    }


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


def _moment(text: str) -> float:
    """Return seconds since the epoch; 0.0 for none."""
    if text == NONE:
        return 0.0
    time = instant(text)
    if isinstance(time, Misfit):
        raise argparse.ArgumentTypeError(f'expected {time.needed}, found {text!r}; {time.hint}')
    return time


def _details(text: str) -> str:
    if text == NONE:
        return '{}'
    try:
        written = text if text.lstrip().startswith('{') else Path(text).read_text('utf-8')
    except (OSError, ValueError) as error:
        what = f'--details is a JSON object or a file with one; {text!r} is none: {error}'
        raise WrongUse(f'queue update: {what}') from None
    details = details_of(written)
    wrong = details if isinstance(details, Wrong) else _first_mistake(Terms(details=details))
    if wrong is not None:
        raise WrongUse(f'queue update: {wrong.what}; {wrong.hint}')
    return json_of(details)


def _first_mistake(terms: Terms) -> Wrong | None:
    return next(wrong_terms(terms), None)
