"""Findings about orders in files, by this program or by a node: they point to the lines."""

from __future__ import annotations

import re
from collections.abc import Sequence

from bt_orchestrator.base.errors import Finding, Refused
from bt_orchestrator.script.orders.order_file import OrderFile, OrderPlaces, key_in, path_of
from bt_orchestrator.script.script_keys import ORDER

_KEYS = '|'.join(ORDER.by_name)
_OF_KEY = re.compile(rf'(?:order|recipe) .*?, ((?:{_KEYS})(?:\.[^:]*)?):1:1: (.*)', re.DOTALL)
_OF_FILE = re.compile(r'(.*?):(\d+):(\d+): (.*)', re.DOTALL)


def pointed(text: str, places: OrderPlaces) -> Finding | None:
    """Return a node's finding about an order, with its place in the file.

    :param text: as a node tells it, with the key of the order where it has one
    :param places: of the order; None is returned for what the file's own mistakes make doubtful
    """
    of_key = _OF_KEY.fullmatch(text)
    if of_key is None:
        return _elsewhere(text, places)
    key, what = of_key.groups()
    known = {key_in('.'.join(path)): path for path in places.places if path}
    path = known.get(key, path_of(key))
    if not places.is_sure(*path):
        return None
    place = places.place(*path)
    return Finding(places.file, place.line, place.column, what)


def _elsewhere(text: str, places: OrderPlaces) -> Finding:
    """Return a finding about another file, as the script, or about the order as a whole."""
    of_file = _OF_FILE.fullmatch(text)
    if of_file is None:
        place = places.place()
        return Finding(places.file, place.line, place.column, text)
    file, line, column, what = of_file.groups()
    return Finding(file, int(line), int(column), what)


# Several orders in files: each needs an id of its own.


def refuse_duplicates(files: Sequence[OrderFile]) -> None:
    """Refuse orders with the id of an order in front of them (formats: work order).

    :raises Refused: with each of them
    """
    first: dict[str, OrderPlaces] = {}
    findings = []
    for file in files:
        name, places = file.order.order, file.places
        if name is not None and first.setdefault(name, places) is not places:
            place = places.place('order')
            before = f'{first[name].file}:{first[name].place("order").line}'
            what = f'the order `{name}` was given before, in {before}'
            findings.append(
                Finding(places.file, place.line, place.column, what, 'choose another id')
            )
    if findings:
        raise Refused(findings)
