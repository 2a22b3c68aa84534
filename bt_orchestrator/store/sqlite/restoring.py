"""Restoring a journal from a copy, as a new history (semantics 9.2)."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing, suppress
from pathlib import Path
from typing import NamedTuple

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.store.shared.database import history_of
from bt_orchestrator.store.shared.mark import MARK, Reached, write_mark
from bt_orchestrator.store.sqlite.database import unchanging, unusable_otherwise
from bt_orchestrator.store.sqlite.keeping import aside_of, copy_file, make_private, sync
from bt_orchestrator.store.sqlite.opening import refuse_in_use, take_lock
from bt_orchestrator.store.sqlite.schema import begin_restored, bring_up_to_date, schema_of

ENDINGS = ('', '-wal', '-shm')
"""File name endings of one journal. The first is removed first: every start refuses a log without
its journal, while a journal without its log looks complete and lacks the newest events."""


class BroughtBack(NamedTuple):
    """The result of a restore."""

    history: str
    last_seq: int
    aside: Path | None
    """Where the previous journal is now; None: there was none."""


def bring_back(copy: Path, path: Path, *, move_aside: bool = False) -> BroughtBack:
    """Restore a journal from a copy; the copy is only read.

    If this is interrupted, even by a power cut, the journal exists completely or not at all.

    :param move_aside: rename an existing journal; otherwise one is a reason for refusal
    :raises JournalUnusable: says what is wrong; no journal was changed
    """
    if not copy.is_file():
        raise JournalUnusable(f'there is no copy {copy}; check the path')
    if copy.resolve() == path.resolve():
        raise JournalUnusable(f'{copy} is the journal itself; name a copy of it')
    refuse_in_use(copy)
    with closing(take_lock(path)):
        if list(_there(path)) and not move_aside:
            raise JournalUnusable(
                f'there is a journal {path}, or a part of one; with --move-aside it is kept '
                'under another name'
            )
        scratch = path.with_name(f'{path.name}.restoring')
        try:
            made = _made(copy, scratch)
            aside = _moved_aside(path)
            _beside(scratch, MARK).rename(_beside(path, MARK))
            scratch.rename(path)
            sync(path.parent)
        except OSError as error:
            what = f'{copy} cannot be brought back as {path}: {error.strerror}'
            raise JournalUnusable(what) from error
        finally:
            _remove(scratch)
    return BroughtBack(made.history, made.seq, aside)


def _made(copy: Path, scratch: Path) -> Reached:
    """Create the complete journal, in the current schema, beside its final place."""
    _remove(scratch)  # left by an interrupted restore
    with unusable_otherwise(copy), closing(unchanging(copy)) as source:
        if not schema_of(source, copy):
            raise JournalUnusable(f'the copy {copy} is empty; name another one')
        make_private(scratch)
        with closing(sqlite3.connect(scratch, isolation_level=None)) as made:
            source.backup(made)
            _refuse_damage(made, copy)
            made.execute('PRAGMA journal_mode = DELETE')
            bring_up_to_date(made, schema_of(made, copy))
            begin_restored(made)
            reached = Reached(history_of(made).id, *_end_of(made))
    sync(scratch)
    write_mark(_beside(scratch, MARK), reached)
    return reached


def _end_of(made: sqlite3.Connection) -> tuple[int, float]:
    """Return the seq and the time of the last event."""
    query = "SELECT seq, json_extract(record, '$.time') FROM events ORDER BY seq DESC LIMIT 1"
    row = made.execute(query).fetchone()
    return (int(row[0]), float(row[1])) if row else (0, 0.0)


def _refuse_damage(made: sqlite3.Connection, copy: Path) -> None:
    (result,) = made.execute('PRAGMA integrity_check(1)').fetchone()
    if result != 'ok':
        raise JournalUnusable(f'the copy {copy} cannot be used: {result}; name another one')


def _moved_aside(path: Path) -> Path | None:
    """Rename the existing files of a journal and return the new name; None: there are none."""
    there = list(_there(path))
    if not there:
        return None
    aside = aside_of(path, 'aside')
    if _beside(path, MARK).exists():  # it stays until replaced by that of the new journal
        copy_file(_beside(path, MARK), _beside(aside, MARK))
    for ending in there:
        _beside(path, ending).rename(_beside(aside, ending))
    sync(path.parent)
    return aside


def _beside(path: Path, ending: str) -> Path:
    return path.with_name(path.name + ending)


def _there(path: Path) -> Iterator[str]:
    return (ending for ending in ENDINGS if _beside(path, ending).exists())


def _remove(scratch: Path) -> None:
    for ending in (*ENDINGS, '-journal', MARK):
        with suppress(FileNotFoundError):
            _beside(scratch, ending).unlink()
