"""Statuses of a small cell: facts as the overview tells them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.model.packml import VERBS, PackmlState, possible_in
from bt_orchestrator.model.state import Hold
from bt_orchestrator.model.status import (
    BeltStatus,
    CellStatus,
    ComponentStatus,
    FlagStatus,
    ItemStatus,
    JobStatus,
    SectionStatus,
    TaskStatus,
)
from bt_orchestrator.model.wait import Wait, WaitKind

NOW_S = 1000.0


def wait(reason: str) -> Wait:
    return Wait(reason, WaitKind.TURN)


def task(id: str, *, name: str = 'TASK_A', attempt: int = 1, since_s: float = 0.0) -> TaskStatus:  # noqa: A002 - as in the status
    return TaskStatus(
        id=id,
        name=name,
        component=id,
        action=f'/{id}/task',
        attempt=attempt,
        goal='',
        started=NOW_S - since_s,
    )


def item(
    id: str,  # noqa: A002 - as in the status
    *,
    empty_position: bool = False,
    rejected: bool = False,
    nonconforming: Sequence[str] = (),
) -> ItemStatus:
    return ItemStatus(id, not empty_position, rejected, tuple(nonconforming))


def section(
    number: int,
    slot: str = '',
    *,
    job: str = 'WO-1',
    running: Sequence[TaskStatus] = (),
    waiting: Sequence[str] = (),
    **of_item: Any,
) -> SectionStatus:
    """Return a section that works on the item in its slot.

    :param of_item: see `item`
    """
    item_status = item(slot, **of_item) if slot else None
    return SectionStatus(
        number=number,
        slot=item_status,
        job=job if item_status else '',
        item=item_status,
        running=tuple(running),
        waits=tuple(map(wait, waiting)),
    )


def job(
    id: str = 'WO-1',  # noqa: A002 - as in the status
    *,
    state: JobWord = JobWord.RUNNING,
    quantity: int = 10,
    **about: Any,
) -> JobStatus:
    return JobStatus(id=id, script='small', state=state, quantity=quantity, **about)


def hold(id: str = '1', **about: Any) -> Hold:  # noqa: A002 - as in the status
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
        'answers': ('retry', 'skip'),
        'since': NOW_S,
    }
    return Hold(id=id, **{**usual, **about})


def component(
    name: str,
    *,
    available: bool = True,
    ready: bool = True,
    state: str = '',
    **about: Any,
) -> ComponentStatus:
    return ComponentStatus(
        name=name,
        action=f'/{name}/task',
        available=available,
        ready=ready,
        state=state,
        **about,
    )


def status(**about: Any) -> CellStatus:
    """Return the status of a cell of two sections, the second one at work."""
    usual = {
        'cell': 'small_cell',
        'stamp': NOW_S,
        'seq': 7,
        'history': 'a',
        'state': PackmlState.EXECUTE,
        'state_since': NOW_S - 12,
        'belt': BeltStatus(),
        'sections': (
            section(1, waiting=['waiting for the belt to move']),
            section(2, 'WO-1/1', running=[task('work', since_s=2.5)]),
        ),
        'components': (component('conveyor'), component('worker')),
        'jobs': (job(started=1, placed=1),),
        'flags': (FlagStatus('clear', 0, 1),),
    }
    lists = {key: tuple(value) for key, value in about.items() if isinstance(value, list)}
    allowed = possible_in(about.get('state', usual['state']))
    commands = tuple(VERBS[cause] for cause in allowed)
    return CellStatus(**{'commands': commands, **usual, **about, **lists})


def long_line(count: int, held: int, working: int) -> CellStatus:
    """Return the status of a line of which one section is held and another works."""
    sections = []
    for number in range(1, count + 1):
        name = f'WO-1/{count - number + 1}'
        if number == working:
            sections.append(section(number, name, running=[task('work', since_s=2.5)]))
        elif number == held:
            sections.append(section(number, name, waiting=['waiting for an answer to hold 1']))
        else:
            sections.append(section(number, name, waiting=['waiting for the belt to move']))
    of_held = hold(section=held, item=f'WO-1/{count + 1 - held}')
    return status(state=PackmlState.HELD, sections=sections, holds=[of_held])
