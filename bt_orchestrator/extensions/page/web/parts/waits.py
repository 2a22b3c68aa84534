"""Waits as parts: as data, and in the words of each language."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import lru_cache
from operator import itemgetter

from bt_orchestrator.extensions.page.web.wording import wordings
from bt_orchestrator.model.codec import plain_but
from bt_orchestrator.model.state import Hold
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.model.status_words import task_label
from bt_orchestrator.model.wait import GRAVE, Wait, WaitKind
from bt_orchestrator.view.report.wait_chains import Root, causes, chains
from bt_orchestrator.view.report.wait_links import Link


def wait_parts(waits: Iterable[Wait], holds: Iterable[Hold]) -> list[dict[str, object]]:
    """Return waits, each sentence once; those of what is not normal go first.

    :param holds: all that there are
    """
    parts = [_wait_part(wait, holds) for wait in {wait.reason: wait for wait in waits}.values()]
    return sorted(parts, key=itemgetter('is_ordinary'))


def _wait_part(wait: Wait, holds: Iterable[Hold]) -> dict[str, object]:
    return {
        **plain_but(wait, 'reason'),
        'words': wait.reason,
        'said': _said(wait, holds),
        'is_ordinary': wait.kind not in GRAVE or wait.kind is WaitKind.CELL_STATE,
    }


def _said(wait: Wait, holds: Iterable[Hold]) -> dict[str, str]:
    """Return what something waits for, in each language of the page."""
    hold = next((hold for hold in holds if wait.name in (hold.id, hold.item)), None)
    task, reason = (task_label(hold.task or '', hold.name), hold.reason) if hold else ('', '')
    return _worded(wait, task, reason)


@lru_cache(maxsize=1024)
def _worded(wait: Wait, task: str, reason: str) -> dict[str, str]:
    return {language: words.wait(wait, task, reason) for language, words in wordings().items()}


def why_part(status: CellStatus) -> dict[str, object]:
    """Return the walk from each part that waits to its cause, and the causes, gravest first."""
    found = chains(status)
    said = _all_said(status)

    def plain(told: Link | Root) -> dict[str, object]:
        return {**vars(told), 'said': said.get(told.words)}

    return {
        'chains': [
            {'part': one.part, 'links': list(map(plain, one.links)), 'root': plain(one.root)}
            for one in found
        ],
        'causes': [
            {**plain(one.root), 'is_ordinary': one.is_ordinary, 'waiting': list(one.waiting)}
            for one in causes(found, status.state)
        ],
    }


def waits_said(status: CellStatus, language: str) -> Mapping[str, str]:
    """Return the sentences of all waits, by those of the node."""
    return {words: said[language] for words, said in _all_said(status).items()}


def _all_said(status: CellStatus) -> dict[str, dict[str, str]]:
    return {wait.reason: _said(wait, status.holds) for wait in _waits(status)}


def _waits(status: CellStatus) -> Iterator[Wait]:
    yield from (wait for section in status.sections for wait in section.waits)
    yield from (*status.belt.waits, *status.initialization)
