"""How arguments of requests are typed, where it is not as they are declared."""

from __future__ import annotations

import argparse
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bt_orchestrator.base.ordinary_file import read_ordinary
from bt_orchestrator.cli.ordering.order_request import script_name
from bt_orchestrator.model.jobs.order import Terms
from bt_orchestrator.script.field_types import Misfit
from bt_orchestrator.script.instants import instant
from bt_orchestrator.script.orders.asked import NONE
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


TYPED: Mapping[str, tuple[str, Mapping[str, Any]]] = {
    'cell.resume.hold': ('', {'metavar': 'N'}),
    'cell.resume.everyones': ('--all', {}),
    'cell.clear.as_shown': ('', {'metavar': 'SEQ'}),
    'cell.clear.belt': (
        '',
        {'type': _slots, 'metavar': 'SLOTS', 'help': 'every slot, as in 1=WO-1/3,2=empty'},
    ),
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
