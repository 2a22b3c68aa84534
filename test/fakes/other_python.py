"""Python in a process of its own: locks and crashes of files are between processes."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

BACKUP = """
import sqlite3, sys
journal, copy = map(sqlite3.connect, sys.argv[1:])
journal.backup(copy)
copy.close()
journal.close()
"""


def run_python(*words: str) -> str:
    """Run Python with the modules of this one, and return what it prints."""
    done = subprocess.run(
        [sys.executable, *words],
        env={**os.environ, 'PYTHONPATH': os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
        check=True,
        timeout=50,
    )
    return done.stdout.strip()


def back_up(path: Path) -> Path:
    """Copy a journal as `sqlite3 FILE ".backup COPY"` does, and return the copy."""
    copy = path.with_name('copy.sqlite3')
    run_python('-c', BACKUP, str(path), str(copy))
    return copy
