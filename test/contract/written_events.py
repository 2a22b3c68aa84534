"""Events that the contracts of journals write: of several jobs, and of none."""

from __future__ import annotations

from bt_orchestrator.model import events as e
from bt_orchestrator.model.events import Event


def events(first: int, last: int) -> list[Event]:
    """Return events with these numbers, each half a second after the one before."""
    return [_event(seq) for seq in range(first, last + 1)]


def _event(seq: int) -> Event:
    time, job = seq / 2, f'WO-{seq % 3}'
    match seq % 5:
        case 0:
            return e.JobQueued(seq=seq, time=time, job=job, script='s', digest='d', quantity=2)
        case 1:
            return e.JobStarted(seq=seq, time=time, job=job)
        case 2:
            return e.BeltIndexed(seq=seq, time=time, beat=seq)
        case 3:
            return e.JobCompleted(seq=seq, time=time, job=job, reason='Grüße, \x00 and \ud800')
        case _:
            return e.ItemPlaced(seq=seq, time=time, job=job, section=1, item=f'{job}/1')
