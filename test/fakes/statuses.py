"""Statuses as the tree node sends them, made of plain objects: no ROS 2 is needed."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

NOW_S = 1000


def stamp(seconds: float) -> Any:
    return SimpleNamespace(sec=int(seconds), nanosec=round(seconds % 1 * 1e9))


def task(id: str, *, name: str = 'TASK_A', attempt: int = 1, since_s: float = 0.0) -> Any:  # noqa: A002 - as in the message
    return SimpleNamespace(
        id=id,
        name=name,
        action=f'/{id}/task',
        attempt=attempt,
        started=stamp(NOW_S - since_s),
    )


def section(
    number: int,
    slot: str = '',
    *,
    running: Sequence[Any] = (),
    waiting: Sequence[str] = (),
    empty_position: bool = False,
    rejected: bool = False,
    nonconforming: Sequence[str] = (),
) -> Any:
    return SimpleNamespace(
        section=number,
        slot=slot,
        slot_empty_position=empty_position,
        slot_rejected=rejected,
        slot_nonconforming=nonconforming,
        job='',
        item=slot,
        running=running,
        waiting=waiting,
    )


def job(
    id: str = 'WO-1',  # noqa: A002 - as in the message
    *,
    state: str = 'Running',
    quantity: int = 10,
    expected_end_s: float = -1.0,
    position: int = 0,
    **counts: int,
) -> Any:
    names = ('started', 'placed', 'packed', 'rejected', 'nonconforming', 'missing')
    zeros = dict.fromkeys(names, 0)
    return SimpleNamespace(
        id=id,
        script='small',
        state=state,
        quantity=quantity,
        position=position,
        expected_end_s=expected_end_s,
        priority=0,
        start=stamp(0.0),
        due=stamp(0.0),
        **{**zeros, **counts},
    )


def hold(id: str = '1', **about: Any) -> Any:  # noqa: A002 - as in the message
    usual = {
        'job': 'WO-1',
        'section': 2,
        'item': 'WO-1/1',
        'task': 'work',
        'name': 'TASK_A',
        'component': 'arm',
        'action': '/arm/task',
        'attempt': 1,
        'attempts': 2,
        'reason': 'aborted',
        'message': '',
        'answers': ['retry', 'skip'],
    }
    return SimpleNamespace(id=id, **{**usual, **about})


def component(
    name: str,
    *,
    available: bool = True,
    ready: bool = True,
    state: str = '',
    contested: str = '',
) -> Any:
    return SimpleNamespace(
        name=name,
        action=f'/{name}/task',
        available=available,
        ready=ready,
        state=state,
        contested=contested,
    )


def status(**about: Any) -> Any:
    """Return the status of a cell of two sections, the second one at work."""
    usual = {
        'stamp': stamp(NOW_S),
        'seq': 7,
        'cell': 'small_cell',
        'state': 'Execute',
        'state_since': stamp(NOW_S - 12),
        'stop_reason': '',
        'stop_message': '',
        'journal_failure': '',
        'disk_wait': '',
        'stop_after': '',
        'stopped_by': '',
        'stopped_with': '',
        'stopped_why': '',
        'stopped_at': stamp(0),
        'waits_for': '',
        'belt_moving': False,
        'belt_waiting': [],
        'initialization_waiting': [],
        'sections': [
            section(1, waiting=['waiting for the belt to move']),
            section(2, 'WO-1/1', running=[task('work', since_s=2.5)]),
        ],
        'components': [component('conveyor'), component('worker')],
        'jobs': [job(started=1, placed=1)],
        'queued': 0,
        'flags': [SimpleNamespace(name='clear', count=0, capacity=1)],
        'holds': [],
    }
    return SimpleNamespace(**{**usual, **about})


def long_line(count: int, held: int, working: int) -> Any:
    """Return the status of a line of which one section is held and another works."""
    sections = []
    for number in range(1, count + 1):
        item = f'WO-1/{count - number + 1}'
        if number == working:
            sections.append(section(number, item, running=[task('work', since_s=2.5)]))
        elif number == held:
            sections.append(section(number, item, waiting=['waiting for an answer to hold 1']))
        else:
            sections.append(section(number, item, waiting=['waiting for the belt to move']))
    of_held = hold(section=held, item=f'WO-1/{count + 1 - held}')
    return status(state='Held', sections=sections, holds=[of_held])
