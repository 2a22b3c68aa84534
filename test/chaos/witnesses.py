"""What readers and copies say, against the journal."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from chaos.copying import BACKUP, digest_of

Record = Mapping[str, Any]

_STARTED = 'orchestrator.started'


def vanished(journal: Sequence[Record], heard: Sequence[Record], who: str) -> Iterator[str]:
    """Say what somebody was told that is not in the journal, or is there otherwise."""
    by_seq = {record['seq']: record for record in journal}
    missing = [record for record in heard if by_seq.get(record['seq']) != record]
    if missing:
        first = missing[0]
        yield (
            f'{who} was told of {len(missing)} events that are not in the journal, first '
            f'{first["seq"]} ({first["event"]})'
        )


def misled(delivered: Sequence[Record], who: str) -> Iterator[str]:
    """Say where a reader's events are not one after the other.

    Who is told of another history begins anew.
    """
    last, history = -1, None
    for record in delivered:
        seq = record['seq']
        current = record.get('history', history) if record['event'] == _STARTED else history
        if last != -1 and (history is None or current == history):
            if seq <= last:
                yield f'{who} was told of event {seq} after event {last}'
            elif seq > last + 1:
                yield f'{who} was not told of the events {last + 1} to {seq - 1}'
        last, history = seq, current


def bad_copies(rows: Sequence[tuple[int, str]], copies: Sequence[Record]) -> Iterator[str]:
    """Say which copies are damaged, or are not how the journal begins.

    :param rows: number and text of the journal's records
    :param copies: as `copying.py` writes them
    """
    expected = {n: digest_of(rows[:n]) for n in {c['events'] for c in copies if 'events' in c}}
    for number, copy in enumerate(copies, 1):
        if 'refused' in copy:
            continue  # in words, by SQLite: somebody can try again
        what = f'{"copy" if copy["kind"] == BACKUP else "reading"} {number}'
        if copy['check'] != 'ok':
            yield f'{what} is damaged: {copy["check"]}'
        elif copy['events'] > len(rows) or copy['digest'] != expected[copy['events']]:
            yield f'{what}, of {copy["events"]} events, is not how the journal begins'
    tried = [copy.get('refused') for copy in copies if copy['kind'] == BACKUP]
    if tried and all(tried):
        yield f'of {len(tried)} copies none was made: {tried[0]}'
