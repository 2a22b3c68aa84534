"""Backs up the journal of an orchestrator that lives, again and again, and reads it as others do.

    python test/chaos/copying.py JOURNAL PID FOLDER

Begins as soon as the process PID has the journal open, and ends with it: who copies a journal that
nobody writes tidies up the log beside it, and a start after a crash is to find that. What was in
each copy is appended to FOLDER/copies.jsonl, a line each. Needs nothing but Python's own library.
"""

from __future__ import annotations

import hashlib
import json
import shutil
import sqlite3
import subprocess
import sys
import time
from collections.abc import Iterable
from contextlib import closing
from pathlib import Path
from typing import Any

COPIES = 'copies.jsonl'

BACKUP, READ = 'backup', 'read'

_LOOK_S = 0.01
_EVERY_S = 0.3

_WITHOUT_THE_PROGRAM = """
import contextlib, sqlite3, sys
with contextlib.closing(sqlite3.connect(sys.argv[1])) as journal:
    with contextlib.closing(sqlite3.connect(sys.argv[2])) as copy:
        journal.backup(copy)
"""


def digest_of(rows: Iterable[tuple[int, str]]) -> str:
    """Return a digest of events, given as number and record."""
    digest = hashlib.sha256()
    for seq, record in rows:
        digest.update(f'{seq} {record}\n'.encode())
    return digest.hexdigest()


def main(journal: Path, pid: int, folder: Path) -> None:
    """Copy and read until the process has ended."""
    after_crash = _has_log(journal)
    if not _wait_open(journal, pid):
        return
    while _is_there(pid):
        for kind, look in ((BACKUP, _back_up), (READ, _read)):
            record = {'kind': kind, 'after_crash': after_crash, **look(journal, folder)}
            with (folder / COPIES).open('a') as file:
                file.write(json.dumps(record) + '\n')
        time.sleep(_EVERY_S)


def _back_up(journal: Path, folder: Path) -> dict[str, Any]:
    copy = folder / 'copy.sqlite3'
    copy.unlink(missing_ok=True)
    command = ['sqlite3', str(journal), f'.backup {copy}']
    if shutil.which('sqlite3') is None:
        command = [sys.executable, '-c', _WITHOUT_THE_PROGRAM, str(journal), str(copy)]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    if done.returncode:
        return {'refused': done.stderr.strip()}
    try:
        return _content(copy)
    except sqlite3.Error as error:
        return {'check': str(error), 'events': 0, 'digest': ''}


def _read(journal: Path, _: Path) -> dict[str, Any]:
    try:
        return _content(journal)
    except sqlite3.Error as error:
        return {'refused': str(error)}


def _content(path: Path) -> dict[str, Any]:
    """Return what is in a journal, which has no tables yet at first."""
    with closing(sqlite3.connect(f'file:{path}?mode=ro', uri=True)) as database:
        (check,) = database.execute('PRAGMA integrity_check').fetchone()
        (tables,) = database.execute('SELECT count(*) FROM sqlite_schema').fetchone()
        query = 'SELECT seq, record FROM events ORDER BY seq'
        rows = database.execute(query).fetchall() if tables else []
    return {'check': check, 'events': len(rows), 'digest': digest_of(rows)}


def _wait_open(journal: Path, pid: int) -> bool:
    """Wait until a process has the journal open; False: it has ended."""
    while _is_there(pid):
        try:
            links = [str(link.readlink()) for link in Path(f'/proc/{pid}/fd').iterdir()]
        except OSError:
            links = []  # of a file that was closed meanwhile, or of a process that ended
        if str(journal.resolve()) in links:
            return True
        time.sleep(_LOOK_S)
    return False


def _has_log(journal: Path) -> bool:
    log = journal.with_name(journal.name + '-wal')
    return log.exists() and log.stat().st_size > 0


def _is_there(pid: int) -> bool:
    try:
        state = Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()[0]
    except OSError:
        return False
    return state != 'Z'


if __name__ == '__main__':
    main(Path(sys.argv[1]), int(sys.argv[2]), Path(sys.argv[3]))
