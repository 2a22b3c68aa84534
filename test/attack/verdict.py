"""What controllers, journal and status say when all attacks are over."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from chaos.truth import Controllers, judge, rows
from chaos.witnesses import vanished

from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import from_record
from bt_orchestrator.ros.types.messages import to_plain

_OF_THE_MOMENT = frozenset(
    [
        'stamp',
        'uptime',
        'stands',
        'state_times',
        'state_since',
        'expected_end_s',
        'components',
        'seq',
        'holds',
        'state',
        'stop_reason',
        'stop_message',
        'commands',
        'waits',
        'belt_waits',
        'initialization_waits',
        'expected_s',
    ]
)
"""What a status says of the process that publishes it, and not of the line.

The cell of a node that has just started may wait for its servers, or for an operator.
"""


@dataclass
class Claims:
    """What is known of a line without its journal."""

    foreign_goals: set[str] = field(default_factory=set)
    """Sent to controllers by somebody else."""
    orders: Sequence[str] = ()
    """Given by the operator, all good."""


def judge_end(
    path: Path,
    log: Path,
    heard: Sequence[Mapping[str, Any]],
    claims: Claims,
    shown: Any,
    replayed: Any,
) -> list[str]:
    """Return every fault, in words.

    :param heard: events that the operator was told of
    :param shown: the last status of the node that was attacked
    :param replayed: the first one of a node that took over from the journal
    """
    records = [json.loads(record) for _, record in rows(path)]
    events = [from_record(record) for record in records]
    controllers = Controllers(log)
    for goal in claims.foreign_goals:
        controllers.by_goal.pop(goal, None)
    verdict = judge(events, controllers, {})
    verdict.vanished += vanished(records, heard, 'the operator')
    return [
        *verdict.faults,
        *_without_an_end(events, claims.orders),
        *_differences(to_plain(shown), to_plain(replayed)),
    ]


def _without_an_end(events: Sequence[e.Event], orders: Sequence[str]) -> Iterator[str]:
    completed = {event.job for event in events if isinstance(event, e.JobCompleted)}
    for order in orders:
        if order not in completed:
            yield f'order {order} was given and has not been completed'


def _differences(shown: Any, replayed: Any, where: str = 'status') -> Iterator[str]:
    """Say where the journal replays to something else than was shown."""
    if isinstance(shown, dict) and isinstance(replayed, dict):
        for name, value in shown.items():
            if name not in _OF_THE_MOMENT:
                yield from _differences(value, replayed.get(name), f'{where}.{name}')
    elif isinstance(shown, list) and isinstance(replayed, list) and len(shown) == len(replayed):
        for number, (element, other) in enumerate(zip(shown, replayed, strict=True)):
            yield from _differences(element, other, f'{where}[{number}]')
    elif shown != replayed:
        yield f'{where} was shown as {shown!r:.200}, and replays to {replayed!r:.200}'
