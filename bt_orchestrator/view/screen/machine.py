"""The view for machines: one JSON object a line whenever something is different."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from typing import Any, Protocol

from bt_orchestrator.model.branch import Branch
from bt_orchestrator.model.codec import from_plain, to_plain
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.frozen import changed
from bt_orchestrator.model.requests.offers import allowed, roles_of
from bt_orchestrator.model.status import CellStatus

SILENT_S = 3.0
"""Seconds without a status after which a node counts as away; it sends one a second."""


class Viewer(Protocol):
    """Gets the news as they come; everything in one thread."""

    def on_status(self, status: CellStatus) -> None:
        """Show how the cell stands."""

    def on_event(self, event: Event) -> None:
        """Show what happened."""

    def on_tree(self, tree: Branch) -> None:
        """Show the behaviour tree."""

    def on_blackboard(self, values: Mapping[str, str]) -> None:
        """Show the variables of the blackboard."""

    def refresh(self) -> None:
        """Show how time passes; called a few times a second."""


class Hearing:
    """Since when nothing is heard of a node."""

    def __init__(self, now: float) -> None:
        self._heard_at = now

    def heard(self, now: float) -> None:
        """Take note of a status."""
        self._heard_at = now

    def age_s(self, now: float) -> float:
        """Return how old the last status is."""
        return now - self._heard_at

    def silent_s(self, now: float) -> float | None:
        """Return for how long the node has been away; None: it is there."""
        age_s = self.age_s(now)
        return age_s if age_s > SILENT_S else None


class JsonView:
    """Objects of the kinds `status`, `away`, `tree` and `blackboard`.

    A status is the whole status as `status --json` prints it; it comes again when something has
    changed that is more than the time, and when the node is back. Events are what the verb
    `events` prints.
    """

    def __init__(self, node: str, say: Callable[[str], object]) -> None:
        self._node = node
        self._say = say
        self._hearing = Hearing(time.monotonic())
        self._said: CellStatus | None = None

    def on_status(self, status: CellStatus) -> None:
        """Print a status that says something new."""
        self._hearing.heard(time.monotonic())
        unstamped = _without_time(status)
        if unstamped != self._said:
            self._said = unstamped
            self._print('status', status=plain_status(status))

    def on_event(self, event: Event) -> None:
        """Print nothing: the status follows."""

    def on_tree(self, tree: Branch) -> None:
        """Print the behaviour tree."""
        self._print('tree', tree=_plain_tree(tree))

    def on_blackboard(self, values: Mapping[str, str]) -> None:
        """Print the variables of the blackboard."""
        self._print('blackboard', values=dict(values))

    def refresh(self) -> None:
        """Print once that the node went away; the next status says that it is back."""
        silent_s = self._hearing.silent_s(time.monotonic())
        if silent_s is not None and self._said is not None:
            self._said = None
            self._print('away', silent_s=round(silent_s, 1))

    def _print(self, kind: str, **about: object) -> None:
        self._say(json.dumps({'kind': kind, 'node': self._node, **about}, ensure_ascii=False))


def plain_status(status: CellStatus) -> dict[str, Any]:
    """Return a status for machines, with the answers to each hold that the reader may give."""
    plain: dict[str, Any] = to_plain(status, whole=True)
    for hold in plain['holds']:
        answers = hold['answers']
        mine, roles = allowed(answers, status.unauthenticated_role), roles_of(answers)
        hold.update(zip(_OF_ROLES, (mine, roles), strict=True))
    return plain


_OF_ROLES = ('answers_allowed', 'answer_roles')


def read_status(plain: Mapping[str, Any]) -> CellStatus:
    """Return a status that was printed for machines."""
    holds = [{k: v for k, v in hold.items() if k not in _OF_ROLES} for hold in plain['holds']]
    return from_plain(CellStatus, {**plain, 'holds': holds})


def _without_time(status: CellStatus) -> CellStatus:
    """Return a status that is equal to a later one in which only time has passed."""
    jobs = (
        job
        if job.expected_end_s is None
        else changed(job, expected_end_s=round(status.stamp + job.expected_end_s))
        for job in status.jobs
    )
    return changed(status, stamp=0.0, uptime=0.0, state_times={}, jobs=tuple(jobs))


def _plain_tree(branch: Branch) -> dict[str, object]:
    return {
        'name': branch.name,
        'status': branch.status.name,
        'message': branch.words,
        'children': [_plain_tree(child) for child in branch.children],
    }
