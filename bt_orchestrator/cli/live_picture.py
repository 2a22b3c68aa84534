"""Drawing what a node says, once or again and again."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from pathlib import Path

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.base.ordinary_file import read_ordinary
from bt_orchestrator.base.stop_signals import StopSignals
from bt_orchestrator.cli.door import STEP_S, Ignoring, open_door
from bt_orchestrator.model.jobs.isa95 import OVER
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.view.screen.machine import read_status

LARGEST_FILE = 100_000_000
"""Bytes; a status of 100 jobs and sections has some 200,000."""


class CannotRead(OrchestratorError):
    """The file of a status cannot be read."""


def saved_status(path: Path) -> CellStatus:
    """Read what `status --json` printed.

    :raises CannotRead: there is no such file, or it holds something else
    """
    try:
        found = json.loads(read_ordinary(path, LARGEST_FILE))
    except OSError as error:
        raise CannotRead(f'cannot read {path}: {error.strerror}; check the path') from error
    except (RecursionError, ValueError) as error:
        raise CannotRead(
            f'{path} is not JSON: {error}; expected what status --json prints'
        ) from error
    try:
        return read_status(found)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise CannotRead(
            f'{path} holds no status of a cell ({error!r}); expected what status --json of this '
            'version prints'
        ) from error


def node_status(node: str, timeout_s: float) -> CellStatus:
    """Ask a node.

    :raises NodeUnreachable: it does not answer
    """
    with open_door(node, timeout_s) as door:
        return door.status()


def follow(
    node: str, timeout_s: float, script: str, every_s: float, draw: Callable[[CellStatus], None]
) -> None:
    """Draw every change, until a job of the script has ended and no other one is left, or Ctrl-C.

    :param every_s: shortest time between two drawings
    :raises NodeUnreachable: it does not answer
    """
    newest, course = _Newest(), Course(script)
    with StopSignals() as stop, open_door(node, timeout_s) as door:
        door.follow(newest)
        drawn_at = -every_s
        while not stop.requested and not course.is_over:
            if newest.status is not None and time.monotonic() >= drawn_at + every_s:
                drawn_at = time.monotonic()
                status, newest.status = newest.status, None
                draw(status)
                course.look(status)
            door.turn(STEP_S)


class _Newest(Ignoring):
    """Keeps the last status that came."""

    status: CellStatus | None = None

    def on_status(self, status: CellStatus) -> None:
        self.status = status


class Course:
    """Whether to wait for the jobs of a script. States: expected, live, over."""

    def __init__(self, script: str) -> None:
        self._script = script
        self._was_live = False
        self.is_over = False

    def look(self, status: CellStatus) -> None:
        """Take note of a status."""
        states = [job.state for job in status.jobs if job.script == self._script]
        is_live = any(state not in OVER for state in states)
        self.is_over = self._was_live and not is_live
        self._was_live |= is_live
