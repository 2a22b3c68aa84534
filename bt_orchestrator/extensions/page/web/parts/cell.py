"""The cell as a whole, its holds and its components as parts."""

from __future__ import annotations

from bt_orchestrator.extensions.page.web.offers import (
    add_offer,
    cell_offers,
    component_offers,
    hold_offers,
)
from bt_orchestrator.extensions.page.web.parts.tasks import wait_parts
from bt_orchestrator.extensions.page.web.wording import said_in_each
from bt_orchestrator.model.by import named
from bt_orchestrator.model.codec import plain_but
from bt_orchestrator.model.hold_words import hold_words
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.state import Hold
from bt_orchestrator.model.status import (
    CellDescription,
    CellStatus,
    ComponentDescription,
    ComponentStatus,
)
from bt_orchestrator.model.status_words import component_trouble, task_label
from bt_orchestrator.model.stop_reason import StopReason, Wish
from bt_orchestrator.model.wait import StandCause

WORKING, QUIET, STOPPED, TROUBLE = 'working', 'quiet', 'stopped', 'trouble'
"""Kinds of states: how a page shows one, before anybody has read its word."""

_QUIET = frozenset(
    (
        PackmlState.RESETTING,
        PackmlState.IDLE,
        PackmlState.COMPLETING,
        PackmlState.COMPLETE,
        PackmlState.SUSPENDING,
        PackmlState.SUSPENDED,
    )
)
_STOPPED = frozenset(
    (
        PackmlState.STOPPING,
        PackmlState.STOPPED,
        PackmlState.CLEARING,
        PackmlState.HOLDING,
        PackmlState.HELD,
    )
)


def cell_part(status: CellStatus, description: CellDescription, node: str) -> dict[str, object]:
    """Return the cell: its state, why it stands, and what can be asked of it."""
    role = status.unauthenticated_role
    return {
        **plain_but(status, *_ELSEWHERE),
        'name': status.cell,
        'node': node,
        'state_kind': _kind(status),
        'since': status.state_since,
        'stop_reason': status.stop_reason.value if status.stop_reason else '',
        'stop_said': said_in_each(status.stop_message),
        'wish': _wish_part(status.wish) if status.wish else None,
        'unauthenticated_role': role.value if role else '',
        'initialization': wait_parts(status.initialization, status.holds),
        'offers': cell_offers(status),
        'add': add_offer(),
        'sections': [section.number for section in status.sections],
        'holds': [hold.id for hold in status.holds],
        'jobs': [job.id for job in status.jobs],
        'components': [component.name for component in description.components],
    }


_ELSEWHERE = (
    *('cell', 'stamp', 'seq', 'history', 'state_since', 'stop_reason', 'stop_words', 'wish'),
    *('unauthenticated_role', 'initialization', 'sections', 'holds', 'jobs', 'belt', 'flags'),
    *('components', 'state_times', 'commands'),
)
"""Fields that other parts have, or this one under another name."""


def _wish_part(wish: Wish) -> dict[str, object]:
    return {**plain_but(wish, 'known'), 'who': named(wish.who, wish.known)}


def _kind(status: CellStatus) -> str:
    state, reason = status.state, status.stop_reason
    aborts = state in (PackmlState.ABORTING, PackmlState.ABORTED)
    if status.journal_failure or aborts:
        return TROUBLE
    if reason in (StopReason.OWN_FAULT, StopReason.EMERGENCY):
        return TROUBLE
    if state in _STOPPED or (status.stands and status.stands.cause is not StandCause.ORDER):
        return STOPPED
    return QUIET if state in _QUIET else WORKING


def now_part(status: CellStatus) -> dict[str, object]:
    """Return the moment of the status."""
    return {'seq': status.seq, 'history': status.history, 'stamp': status.stamp}


def hold_part(hold: Hold) -> dict[str, object]:
    """Return a hold with the answers that are possible."""
    return {
        **plain_but(hold, 'answers', 'answers_together', 'message_words'),
        'task': hold.task or '',
        'label': task_label(hold.task or '', hold.name),
        'item': hold.item or '',
        'job': hold.job or '',
        'together': list(hold.answers_together),
        'words': hold_words(hold),
        'said': said_in_each(hold.message),
        'is_pause': hold.is_pause,
        'offers': hold_offers(hold),
    }


def component_part(
    component: ComponentStatus, described: ComponentDescription | None
) -> dict[str, object]:
    """Return a component; its trouble in words."""
    return {
        **plain_but(component),
        'contested_said': said_in_each(component.contested),
        'sections': list(described.sections) if described else [],
        'trouble': component_trouble(component),
        'offers': component_offers(component),
    }
