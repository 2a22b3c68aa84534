"""Waits as parts: with their structure, so that a browser can say them in its own language."""

from __future__ import annotations

from collections.abc import Iterable

from bt_orchestrator.model.codec import plain_but
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.model.wait import Wait, WaitKind
from bt_orchestrator.report.wait_chains import Cause, Chain, causes, chains

_ORDINARY = frozenset(
    (
        WaitKind.BELT,
        WaitKind.TURN,
        WaitKind.ITEM,
        WaitKind.JOB,
        WaitKind.FLAG,
        WaitKind.ZONE,
        WaitKind.COMPONENT,
        WaitKind.INITIALIZATION,
        WaitKind.CELL_STATE,
    )
)
"""Kinds that belong to a line that works, and are shown quietly."""


def wait_parts(waits: Iterable[Wait]) -> list[dict[str, object]]:
    """Return waits, each sentence once."""
    return [_wait_part(wait) for wait in {wait.reason: wait for wait in waits}.values()]


def _wait_part(wait: Wait) -> dict[str, object]:
    return {
        **plain_but(wait, 'reason'),
        'words': wait.reason,
        'is_ordinary': wait.kind in _ORDINARY,
    }


def why_part(status: CellStatus) -> dict[str, object]:
    """Return the walk from each part that waits to its cause, and the causes, gravest first."""
    found = chains(status)
    return {
        'chains': list(map(_chain_part, found)),
        'causes': list(map(_cause_part, causes(found, status.state))),
    }


def _cause_part(cause: Cause) -> dict[str, object]:
    return {
        **vars(cause.root),
        'is_ordinary': cause.is_ordinary,
        'waiting': list(cause.waiting),
    }


def _chain_part(chain: Chain) -> dict[str, object]:
    return {
        'part': chain.part,
        'links': [dict(vars(link)) for link in chain.links],
        'root': dict(vars(chain.root)),
    }
