"""Converts typed work orders to the texts that the order desk reads."""

from __future__ import annotations

import json
from collections.abc import Mapping
from datetime import datetime, timezone
from typing import Any

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.jobs.order import RecipeChoice, WorkOrder
from bt_orchestrator.model.words import joined, sentence
from bt_orchestrator.script.field_types import Misfit
from bt_orchestrator.script.orders.desk import AskedOrder
from bt_orchestrator.script.orders.instants import instant
from bt_orchestrator.script.orders.terms import AskedTerms
from bt_orchestrator.script.yaml_nodes import quoted

NONE = 'none'
"""The value that removes a time from a job."""


def asked_of(order: AskedOrder | WorkOrder | Mapping[str, Any]) -> AskedOrder:
    """Return a work order as texts.

    :param order: or a mapping with the keys of an order file, which the desk reads
    :raises CommandRefused: it is neither
    """
    if isinstance(order, AskedOrder):
        return order
    if isinstance(order, Mapping):
        name, script = str(order.get('order') or ''), str(order.get('script') or '')
        return AskedOrder(script, name, text=json.dumps(order, indent=1, ensure_ascii=False))
    if not isinstance(order, WorkOrder):
        raise CommandRefused(sentence('no_order', found=f'{order!r:.60}'))
    terms = order.terms
    details = json_of(terms.details) if terms.details else ''
    piece = terms.first_piece or None
    asked = AskedTerms(terms.priority or None, terms.start, terms.due, details, piece)
    texts = written(order.params)
    quantity = order.quantity or 0
    return AskedOrder(order.script, order.order or '', quantity, texts, asked, order.recipe)


def mapping_of(order: WorkOrder) -> dict[str, Any]:
    """Return an order as a mapping with the keys of an order file."""
    terms, choice = order.terms, order.recipe
    given = {
        'order': order.order,
        'script': order.script,
        'recipe': list(choice.recipes) if choice else None,
        'version': choice.version if choice else None,
        'bind': dict(choice.bind) if choice else None,
        'quantity': order.quantity,
        'params': dict(order.params),
        'priority': terms.priority,
        'start': _in_utc(terms.start),
        'due': _in_utc(terms.due),
        'details': dict(terms.details),
        'first_piece': terms.first_piece,
    }
    return {key: value for key, value in given.items() if value}


def _in_utc(seconds: float | None) -> str | None:
    if seconds is None:
        return None
    return datetime.fromtimestamp(seconds, timezone.utc).isoformat()


def change_of(given: Mapping[str, Any]) -> AskedOrder:
    """Return what a queued job is to be, from the arguments of the request job.update.

    A version or a binding alone is of the recipe that the job has.

    :raises CommandRefused: a time is none
    """
    details = given.get('details')
    terms = AskedTerms(
        given.get('priority'),
        _moment(given, 'start'),
        _moment(given, 'due'),
        '' if details is None else json_of(details),
    )
    texts = written(given.get('params', {}))
    quantity, recipe = given.get('quantity', 0), choice_of(given)
    return AskedOrder(given.get('script', ''), '', quantity, texts, terms, recipe)


def choice_of(given: Mapping[str, Any]) -> RecipeChoice | None:
    """Return what a change says of the recipe of a queued job; None: nothing."""
    recipes, version, bind = (given.get(key) for key in ('recipe', 'version', 'bind'))
    if not recipes and not version and not bind:
        return None
    return RecipeChoice(tuple(recipes or ()), version or None, bind or {})


def written(params: Mapping[str, Any]) -> dict[str, str]:
    """Return parameters of a script as they are written in YAML."""
    return {
        key: value if isinstance(value, str) else json.dumps(value)
        for key, value in params.items()
    }


def _moment(given: Mapping[str, Any], key: str) -> float | None:
    """Return seconds since the epoch; 0.0: none is wanted; None: nothing is said."""
    text = given.get(key)
    if text is None or text == NONE:
        return None if text is None else 0.0
    time = instant(text)
    if isinstance(time, Misfit):
        words = sentence('key', key=key, needed=time.needed, given=quoted(text))
        raise CommandRefused(joined(words, time.hint))
    return time
