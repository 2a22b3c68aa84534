"""The numbers of events: each is one more than the number before it."""

from __future__ import annotations

from collections.abc import Sequence

from bt_orchestrator.base.errors import JournalFailed
from bt_orchestrator.model.events import Event


def refuse_gap(events: Sequence[Event], last: int) -> None:
    """Check that events have the next numbers.

    :param last: number of the last event in the journal; 0: there is none
    :raises JournalFailed: one of them has another number; nothing was written
    """
    if [event.seq for event in events] == list(range(last + 1, last + 1 + len(events))):
        return
    for event in events:
        if event.seq != last + 1:
            raise JournalFailed(
                f'event {event.seq} cannot follow event {last}: the next event of the journal is '
                f'{last + 1}; does another orchestrator write it?'
            )
        last = event.seq
