"""The parts of a cell as messages (SectionStatus, ComponentStatus, HoldStatus), and back."""

from __future__ import annotations

from collections.abc import Sequence

from bt_orchestrator_interfaces import msg

from bt_orchestrator.model.state import Hold
from bt_orchestrator.model.status import ComponentStatus, ItemStatus, SectionStatus
from bt_orchestrator.ros.stamps import from_moment, from_time, to_moment, to_time
from bt_orchestrator.ros.types.fact_messages import (
    finished_message,
    finished_of,
    words_message,
    words_of,
)
from bt_orchestrator.ros.types.task_messages import (
    passed_message,
    passed_task,
    task_message,
    task_status,
    wait_message,
    wait_of,
)

_NOTHING = ItemStatus('')
"""Where there is no item: an empty text in a message."""


def section_message(section: SectionStatus) -> msg.SectionStatus:
    """Return the message about a section."""
    slot, item = section.slot or _NOTHING, section.item or _NOTHING
    return msg.SectionStatus(
        section=section.number,
        slot=slot.id,
        slot_empty_position=not slot.present,
        slot_rejected=slot.rejected,
        slot_nonconforming=slot.nonconforming,
        job=section.job,
        item=item.id,
        item_empty_position=not item.present,
        item_rejected=item.rejected,
        item_nonconforming=item.nonconforming,
        running=[task_message(task) for task in section.running],
        passed=[passed_message(task) for task in section.passed],
        failed=section.failed,
        waits=[wait_message(wait) for wait in section.waits],
        finished=finished_message(section.finished),
    )


def section_status(message: msg.SectionStatus) -> SectionStatus:
    """Return what a message says of a section."""
    return SectionStatus(
        number=message.section,
        slot=_item(
            message.slot,
            message.slot_empty_position,
            message.slot_rejected,
            message.slot_nonconforming,
        ),
        job=message.job,
        item=_item(
            message.item,
            message.item_empty_position,
            message.item_rejected,
            message.item_nonconforming,
        ),
        running=tuple(map(task_status, message.running)),
        passed=tuple(map(passed_task, message.passed)),
        failed=tuple(message.failed),
        waits=tuple(map(wait_of, message.waits)),
        finished=finished_of(message.finished),
    )


def _item(
    id_: str,
    is_empty_position: bool,
    is_rejected: bool,
    nonconforming: Sequence[str],
) -> ItemStatus | None:
    if not id_:
        return None
    return ItemStatus(id_, not is_empty_position, is_rejected, tuple(nonconforming))


def component_message(component: ComponentStatus) -> msg.ComponentStatus:
    """Return the message about a component."""
    return msg.ComponentStatus(
        name=component.name,
        action=component.action,
        available=component.available,
        ready=component.ready,
        contested=component.contested,
        contested_words=words_message(component.contested_words),
        out_of_service=component.out_of_service,
        out_of_service_since=to_moment(component.out_of_service_since),
        state=component.state,
        task=component.task,
        feedback=component.feedback,
    )


def component_status(message: msg.ComponentStatus) -> ComponentStatus:
    """Return what a message says of a component."""
    return ComponentStatus(
        name=message.name,
        action=message.action,
        available=message.available,
        ready=message.ready,
        contested=message.contested,
        contested_words=words_of(message.contested_words),
        out_of_service=message.out_of_service,
        out_of_service_since=from_moment(message.out_of_service_since),
        state=message.state,
        task=message.task,
        feedback=message.feedback,
    )


def hold_message(hold: Hold) -> msg.HoldStatus:
    """Return the message about a hold."""
    return msg.HoldStatus(
        id=hold.id,
        job=hold.job or '',
        section=hold.section or 0,
        item=hold.item or '',
        task=hold.task or '',
        name=hold.name,
        component=hold.component,
        action=hold.action,
        attempt=hold.attempt,
        attempts=hold.attempts,
        reason=hold.reason,
        message=hold.message,
        answers=hold.answers,
        owner=hold.owner,
        round=hold.round,
        message_words=[words_message(words) for words in hold.message_words],
        controller_said=hold.controller_said,
        last_feedback=hold.last_feedback,
        topic_says=hold.topic_says,
        answers_why=hold.answers_why,
        since=to_time(hold.since),
    )


def hold_of(message: msg.HoldStatus) -> Hold:
    """Return what a message says of a hold."""
    return Hold(
        id=message.id,
        job=message.job or None,
        section=message.section or None,
        item=message.item or None,
        task=message.task or None,
        reason=message.reason,
        message=message.message,
        answers=tuple(message.answers),
        since=from_time(message.since),
        owner=message.owner,
        name=message.name,
        component=message.component,
        action=message.action,
        attempt=message.attempt,
        attempts=message.attempts,
        round=message.round,
        message_words=tuple(filter(None, map(words_of, message.message_words))),
        controller_said=message.controller_said,
        last_feedback=message.last_feedback,
        topic_says=message.topic_says,
        answers_why=message.answers_why,
    )
