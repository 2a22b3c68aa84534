"""Lost events of a journal, found by its mark and its rows, in words."""

from __future__ import annotations

import sqlite3
from datetime import datetime, timezone
from pathlib import Path

from bt_orchestrator.store.sqlite.database import has_log, log_of
from bt_orchestrator.store.sqlite.mark import Mark, mark_of
from bt_orchestrator.store.sqlite.schema import is_closed


def shortfall(mark: Mark, history: str, last_row: int, read: int) -> str:
    """Say what was written and is lost; empty: nothing, as far as is known.

    :param history: id of the journal's history
    :param last_row: the last event that has a row, damaged or not
    :param read: the event up to which the journal could be read
    """
    found = mark.found
    if found is not None and found.history != history:
        return (
            f'{mark.path.name} is of another journal (history {found.history}), which was written '
            f'here up to event {found.seq} of {_utc(found.time)}: the file was replaced, or the '
            'mark was'
        )
    marked = found.seq if found is not None else 0
    number = max(marked, last_row) - read
    if number <= 0:
        return ''
    what = f'{number} event{"s are" if number > 1 else " is"} missing'
    if last_row > read:
        return f'{what}: a record after event {read} is damaged, or it is not there'
    assert found is not None
    return f'{what}: event {found.seq} of {_utc(found.time)} had been written'


def is_cut_off(database: sqlite3.Connection, path: Path) -> bool:
    """Tell whether a node left a log beside a journal, and it is now missing."""
    if has_log(path) or is_closed(database):
        return False
    return not has_log(path)  # a node may have begun writing meanwhile


def cut_off(path: Path, last: int) -> str:
    """Say what is known of a journal without its log and its mark."""
    return (
        f'events after event {last} may be missing: the node that wrote the journal did not close '
        f'it, and neither {log_of(path).name} nor {mark_of(path).name} is there'
    )


def _utc(seconds: float) -> str:
    try:
        moment = datetime.fromtimestamp(seconds, timezone.utc)
    except (OverflowError, ValueError, OSError):
        return f'{seconds:g} s'
    return f'{moment:%Y-%m-%d %H:%M:%S} UTC'
