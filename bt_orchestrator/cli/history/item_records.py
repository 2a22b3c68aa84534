"""Records of single items, as JSON or as one HTML document."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.cli.wrong_use import WrongUse
from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.keeping.journal_place import JournalPlace
from bt_orchestrator.view.drawing.documents.item_page import Source, item_page
from bt_orchestrator.view.report.item.history import ItemHistory, plain_item
from bt_orchestrator.view.report.item.reader import item_history
from bt_orchestrator.view.report.reading import Reading

MOST_ITEMS = 500
"""More than this in one document is too slow for a browser and too long for a reader."""


class NoItem(OrchestratorError):
    """A journal does not have an item."""


def histories(reading: Reading, journal: JournalPlace, items: Iterable[str]) -> list[ItemHistory]:
    """Read the records of items, in the order named.

    :raises NoItem: the journal does not have one of them
    """
    found = []
    for item in items:
        history = item_history(reading, item)
        if history is None:
            raise NoItem(
                f'the journal {journal} knows no item {item}: it never was, or its events are not '
                'kept any more; `bt-orchestrator history --job JOB --items` names the items of a '
                'job'
            )
        found.append(history)
    return found


def refuse_too_many(items: Sequence[str]) -> None:
    """Refuse what makes no document.

    :raises WrongUse: there are too many items
    """
    if len(items) > MOST_ITEMS:
        raise WrongUse(
            f'{len(items)} items are too many for one document, which has {MOST_ITEMS} at most: '
            'choose with --serial, --job, --from and --to; --record writes them all as JSON'
        )


def as_json(items: Iterable[ItemHistory]) -> str:
    """Return records as JSON, one object an item and line."""
    return ''.join(f'{json_of(plain_item(item))}\n' for item in items)


def as_html(
    items: Sequence[ItemHistory], journal: JournalPlace, title: str, lacks: Sequence[str]
) -> str:
    """Return records as one document.

    :param lacks: what of the journal could not be read
    """
    return item_page(items, Source(f'the journal {journal}', time.time(), lacks), title)
