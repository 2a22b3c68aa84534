"""A program of the tests that is ended leaves no process, even one that it has just started."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

TEST = Path(__file__).parents[1]
PROGRAM = """
import subprocess
import sys

import interrupts

interrupts.heed()
child = subprocess.Popen([sys.executable, '-c', 'input()'], stdin=0, start_new_session=True)
print(child.pid, flush=True)
raise KeyboardInterrupt
"""


def test_what_nobody_has_ends_with_the_program() -> None:
    reader, writer = os.pipe()  # nothing comes, and no end as long as this test runs
    try:
        ended = subprocess.run(
            [sys.executable, '-c', PROGRAM],
            stdin=reader,
            capture_output=True,
            text=True,
            env={**os.environ, 'PYTHONPATH': str(TEST)},
            check=False,
        )
        assert 'KeyboardInterrupt' in ended.stderr
        assert not Path('/proc', ended.stdout.strip()).exists()
    finally:
        os.close(reader)
        os.close(writer)
