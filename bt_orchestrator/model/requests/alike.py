"""Holds that ask the same: one list may carry their answers.

After a restart every goal in flight can be such a question. Each answer of a list is a request and
a record of its own. Answered singly are the belt, tasks that place or take out an item, and every
answer that moves something again.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bt_orchestrator.model.failures import MARK_DONE, REJECT, SKIP
from bt_orchestrator.model.goal import Reason
from bt_orchestrator.model.script import Task
from bt_orchestrator.model.state import Hold

TOGETHER = (MARK_DONE, SKIP, REJECT)
"""Answers that a list may carry."""


def together(hold: Hold, task: Task, offered: Iterable[str]) -> tuple[str, ...]:
    """Return the answers to a hold that a list may carry; none: it is answered singly.

    :param task: the one that is held
    """
    is_doubt = hold.reason == Reason.IN_DOUBT.value and hold.job is not None
    if not is_doubt or task.qty_change:
        return ()
    return tuple(answer for answer in offered if answer in TOGETHER)


def alike(holds: Iterable[Hold]) -> list[Sequence[Hold]]:
    """Return the groups of two or more holds that a list may answer, in the order of the holds."""
    groups: dict[tuple[str, ...], list[Hold]] = {}
    for hold in holds:
        answers = hold.answers_together
        if answers:
            groups.setdefault(tuple(sorted(answers)), []).append(hold)
    return [group for group in groups.values() if len(group) > 1]


def why_singly(hold: Hold, answer: str) -> str:
    """Say why a list may not carry an answer to a hold; empty: it may."""
    possible = hold.answers_together
    if answer in possible:
        return ''
    offered = (
        f'a list can answer it with {", ".join(possible)}' if possible else 'answer it singly'
    )
    return f'hold {hold.id} ({hold.task or "the cell"}: {hold.reason}): {offered}; found {answer}'
