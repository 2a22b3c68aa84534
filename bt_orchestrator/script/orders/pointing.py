"""Findings of a node about an order that came from a file: they point to the lines of the file."""

from __future__ import annotations

import re

from bt_orchestrator.base.errors import Finding
from bt_orchestrator.script.orders.order_file import OrderPlaces, key_in, path_of
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
