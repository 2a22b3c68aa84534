"""Python in a process of its own: locks and crashes of files are between processes."""

from __future__ import annotations

import os
import subprocess
import sys


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
