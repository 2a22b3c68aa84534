"""What a step says of one thing that it looked at."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

# Of the environment that this runs in: a tool, or a new environment, has its own.
FOREIGN = ('PYTHON', 'AMENT_', 'ROS_', '_ROS_', 'LD_', 'VIRTUAL_ENV', 'FAST')


@dataclass(frozen=True)
class Outcome:
    """`found` is a line for people; `done` is False where nothing could be looked at."""

    what: str
    found: str
    failed: bool = False
    done: bool = True

    def __str__(self) -> str:
        word = 'FAILED' if self.failed else 'ok' if self.done else 'NOT DONE'
        return f'{word:8} {self.what}: {self.found}'


@dataclass(frozen=True)
class Place:
    """Where the project, the tools (a folder of programs) and the results are."""

    root: Path
    tools: Path
    write: bool = False

    @property
    def lists(self) -> Path:
        return self.root / 'scripts' / 'requirements'

    @property
    def results(self) -> Path:
        (folder := self.root / 'dist').mkdir(exist_ok=True)
        return folder


NOTHING: Mapping[str, str] = {}


def run(
    *command: str | Path, cwd: Path | None = None, variables: Mapping[str, str] = NOTHING
) -> subprocess.CompletedProcess[str]:
    """Run a program without the variables of this environment; nothing of it is shown."""
    own = {name: text for name, text in os.environ.items() if not name.startswith(FOREIGN)}
    return subprocess.run(
        [str(word) for word in command],
        cwd=cwd,
        env={**own, **variables},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )


def end_of(done: subprocess.CompletedProcess[str], lines: int = 15) -> str:
    """Return the last lines of what a program printed, for a line that says that it failed."""
    printed = (done.stdout + done.stderr).strip().splitlines()
    return '\n           '.join((f'status {done.returncode}', *printed[-lines:]))
