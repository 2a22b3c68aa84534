"""The losses of planned time, with the words for them (docs/account.md)."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import NamedTuple

from bt_orchestrator.model.stop_reason import StopReason


class Step(Enum):
    """The part of the account that a loss belongs to."""

    NOT_BUSY = 'not busy'
    """Taken off the planned time before anything is judged."""
    AVAILABILITY = 'availability'
    PERFORMANCE = 'performance'
    QUALITY = 'quality'


class Loss(Enum):
    """The losses of time, in the order of the waterfall."""

    NOT_RECORDED = 'not_recorded'
    NO_ORDER = 'no_order'
    ORDERS_WAIT = 'orders_wait'
    NO_NODE = 'no_node'
    OWN_FAULT = 'own_fault'
    OPERATOR = 'operator'
    STARVED = 'starved'
    BLOCKED = 'blocked'
    EMERGENCY = 'emergency'
    SETUP = 'setup'
    WAITING = 'waiting'
    REWORK = 'rework'
    SLOW = 'slow'
    REJECTS = 'rejects'


class Part(Enum):
    """A part of a loss by what the line waited for."""

    WHOLE = ''
    """The loss has no parts, or books of an older program do not tell them."""
    FAULT = 'fault'
    ANSWER = 'answer'
    PAUSED = 'paused'
    NOT_STARTED = 'not_started'
    MANUAL = 'manual'


class PartWords(NamedTuple):
    """A part of a loss for people."""

    loss: Loss
    title: str


PARTS: Mapping[Part, PartWords] = {
    Part.FAULT: PartWords(Loss.OWN_FAULT, 'fault'),
    Part.ANSWER: PartWords(Loss.OWN_FAULT, 'waiting for an answer'),
    Part.PAUSED: PartWords(Loss.OPERATOR, 'paused'),
    Part.NOT_STARTED: PartWords(Loss.OPERATOR, 'not started'),
    Part.MANUAL: PartWords(Loss.OPERATOR, 'manual'),
}


class Words(NamedTuple):
    """A loss for people."""

    step: Step
    title: str
    meaning: str


WORDS: Mapping[Loss, Words] = {
    Loss.NOT_RECORDED: Words(
        Step.NOT_BUSY,
        'not recorded',
        'the journal does not know it: before its first event, or after events that were removed',
    ),
    Loss.NO_ORDER: Words(Step.NOT_BUSY, 'no order', 'no job was on the line or in the queue'),
    Loss.ORDERS_WAIT: Words(
        Step.NOT_BUSY,
        'orders wait',
        'no job was on the line, and no job in the queue could start: held, before its `start`, '
        'without a release, or in need of a component out of service',
    ),
    Loss.NO_NODE: Words(
        Step.AVAILABILITY,
        'node not running',
        'from the last event before the node ended to its next start, with work to do',
    ),
    Loss.OWN_FAULT: Words(
        Step.AVAILABILITY, 'own fault', 'stop reason `own_fault`: a hold waited for its answer'
    ),
    Loss.OPERATOR: Words(
        Step.AVAILABILITY,
        'operator',
        'stop reason `operator` (a pause, a stop); or there was work, and the cell was not '
        'started, or every job on the line was paused and nothing ran',
    ),
    Loss.STARVED: Words(
        Step.AVAILABILITY, 'starved', 'stop reason `starved`: the source was not ready'
    ),
    Loss.BLOCKED: Words(
        Step.AVAILABILITY, 'blocked', 'stop reason `blocked`: the sink was not ready'
    ),
    Loss.EMERGENCY: Words(
        Step.AVAILABILITY, 'emergency', 'stop reason `emergency`: from `abort` to `clear`'
    ),
    Loss.SETUP: Words(Step.AVAILABILITY, 'setup', 'goals ran, all of them of initialization'),
    Loss.WAITING: Words(
        Step.AVAILABILITY,
        'waiting',
        'no goal ran and there was no stop reason: a component was not ready or out of service, '
        'or a retry waited for its delay',
    ),
    Loss.REWORK: Words(
        Step.PERFORMANCE,
        'rework',
        'a further attempt or a further round ran; at most what the performance lacks',
    ),
    Loss.SLOW: Words(
        Step.PERFORMANCE,
        'slow cycles',
        'the rest: cycles slower than the pace, a line that fills or drains; below 0 where the '
        'line was faster than its pace',
    ),
    Loss.REJECTS: Words(
        Step.QUALITY,
        'rejects',
        'the time, by the pace, of items that were rejected, nonconforming or taken off by hand',
    ),
}

OF_STOP_REASON: Mapping[StopReason, Loss] = {reason: Loss(reason.value) for reason in StopReason}


def is_stop(loss: Loss) -> bool:
    """Tell whether the line stands in the time of a loss that it could have worked in."""
    return WORDS[loss].step is Step.AVAILABILITY


def of_step(step: Step) -> tuple[Loss, ...]:
    """Return the losses of a step, in order."""
    return tuple(loss for loss in Loss if WORDS[loss].step is step)
