"""Messages of the stream as bytes: server-sent events, one JSON object each."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping

WAITING = b': waiting\n\n'
"""A comment: the connection is alive, and nothing has been heard of the cell yet."""

FULL = b'event: full\ndata: {}\n\n'


_NO_NAMES: Mapping[str, str] = {}


def encoded(value: object) -> str:
    """Return strict JSON on one line."""
    return json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(',', ':'))


def message(kind: str, **fields: object) -> bytes:
    """Return a message of these fields."""
    return _framed(kind, encoded(fields))


def begin(history: str, after: int, **fields: object) -> bytes:
    """Return the message that a reader begins with."""
    data = encoded({'history': history, 'after': after, **fields})
    return _framed('begin', data, _id(history, after))


def gap(history: str, first: int, last: int) -> bytes:
    """Return a message of events that are lost."""
    return _framed('gap', encoded({'first': first, 'last': last}), _id(history, last))


def happened(
    history: str, last: int, records: Iterable[str], names: Mapping[str, str] = _NO_NAMES
) -> bytes:
    """Return a message of events, whose id is what a reader comes back with.

    :param records: as JSON
    :param names: for display, of people in the records, by sequence number
    """
    data = f'"history":{encoded(history)},"records":[{",".join(records)}]'
    data = f'{{{data},"names":{encoded(names)}}}' if names else f'{{{data}}}'
    return _framed('happened', data, _id(history, last))


def parts(version: int, changed: Mapping[str, str], gone: Iterable[str]) -> bytes:
    """Return a message of parts that changed.

    :param changed: as JSON, by key
    """
    members = ','.join(f'{encoded(key)}:{text}' for key, text in changed.items())
    data = f'{{"version":{version},"set":{{{members}}},"gone":{encoded(list(gone))}}}'
    return _framed('parts', data)


def _id(history: str, seq: int) -> str:
    """Return the line that a browser remembers, and comes back with."""
    return f'id: {history}:{seq}\n'


def _framed(kind: str, data: str, number: str = '') -> bytes:
    # Half of a surrogate pair has no UTF-8: one bad text must not end a stream.
    return f'event: {kind}\n{number}data: {data}\n\n'.encode(errors='replace')
