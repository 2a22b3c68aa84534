"""The program that copies a journal beside the one that writes it."""

from __future__ import annotations

import json
import os
import sqlite3
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path

import pytest
from chaos.copying import BACKUP, COPIES, READ, digest_of
from chaos.readers import COPYING
from patience import PATIENCE_S

ROWS = [(1, '{"seq": 1}'), (2, '{"seq": 2}')]


WRITER = 'import sys; file = open(sys.argv[1]); sys.stdin.read()'


@pytest.mark.parametrize('path', [os.environ['PATH'], ''], ids=['as found', 'without sqlite3'])
def test_copying_continues_while_journal_is_open(tmp_path: Path, path: str) -> None:
    journal = tmp_path / 'journal.sqlite3'
    with closing(sqlite3.connect(journal)) as database, database:
        database.execute('CREATE TABLE events (seq INTEGER PRIMARY KEY, record TEXT)')
        database.executemany('INSERT INTO events VALUES (?, ?)', ROWS)
    words = [sys.executable, '-c', WRITER, str(journal)]
    with subprocess.Popen(words, stdin=subprocess.PIPE) as writer:
        words = [sys.executable, str(COPYING), str(journal), str(writer.pid), str(tmp_path)]
        with subprocess.Popen(words, env={**os.environ, 'PATH': path}) as copying:
            copies = _until_both(tmp_path / COPIES)
            assert writer.stdin is not None
            writer.stdin.close()
            assert copying.wait(PATIENCE_S) == 0
    content = {'check': 'ok', 'events': 2, 'digest': digest_of(ROWS)}
    expected = [{'kind': kind, 'after_crash': False, **content} for kind in (BACKUP, READ)]
    assert copies[:2] == expected


def _until_both(file: Path) -> list[object]:
    deadline = time.monotonic() + PATIENCE_S
    while not file.exists() or file.read_text().count('\n') < 2:
        assert time.monotonic() < deadline, 'no copy was made'
        time.sleep(0.01)
    return [json.loads(line) for line in file.read_text().splitlines()]
