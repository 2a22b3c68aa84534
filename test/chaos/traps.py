"""Traps of a database with replicas: events that a node takes for kept, and that are lost.

Each is sprung on a real node while goals move, with a real server and a real replica. Then the
server is gone, and the replica takes its place. A round tells what was lost, by the logs of the
controllers and by what the node had published. A trap is worth nothing if no event is lost without
the check that is against it: the same round runs with a patch of test/mutations.
"""

from __future__ import annotations

import json
import random
import signal
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import NamedTuple

from cell_processes import CellProcesses
from chaos.database import Database
from chaos.line import LONG_REMEMBERED_S, SCRIPT, SPEED, cell
from chaos.operator import Operator
from chaos.plan import SHARES
from chaos.truth import Controllers, journal, judge
from chaos.witnesses import vanished
from mutations.run import HERE, applies, copy_package
from patience import PATIENCE_S

ITEMS = 4

_FIRST_GOALS, _MORE_GOALS = 4, 2

_GOES_ON_S = 20.0
"""A node ends within this time, or goes on."""


_PROGRAM = """
import sys
sys.path.insert(0, {copy!r})
from bt_orchestrator.cli.main import main
sys.exit(main(sys.argv[1:]))
"""


class Trap(NamedTuple):
    """One trap, and the check against it."""

    name: str
    patch: str
    """Takes the check out."""
    spring: Callable[[Round], None]
    is_synchronous: bool = True


class Round:
    """A line at work, its database, and what was lost. A context."""

    def __init__(self, folder: Path, trap: Trap, seed: int, copy: Path | None) -> None:
        """Prepare.

        :param copy: where the package is without the check; None: as it is
        """
        folder.mkdir(parents=True)
        self._trap = trap
        self._left = ExitStack()
        self._program = ('-m', 'bt_orchestrator')
        if copy is not None:
            self._program = ('-c', _PROGRAM.format(copy=str(copy)))
        self.database = Database(synchronous=trap.is_synchronous)
        self._left.callback(self.database.close)
        self._cell = CellProcesses(
            folder,
            cell(random.Random(seed), ITEMS, LONG_REMEMBERED_S),
            shares=SHARES,
            speed=SPEED,
            run_options=['--journal', self.database.address, '--auto-resume'],
            node_program=self._program,
        )
        self._left.callback(self._cell.close)
        script = self._cell.script(SCRIPT).stem
        rows, log = self.database.rows, self._cell.log
        self._operator = Operator(self._cell.watch, script, ITEMS, rows, log)

    def run(self) -> list[str]:
        """Spring the trap, let the replica take over, and return what was lost."""
        with self._left:
            self._cell.connect()
            self.live(lambda: self._goals >= _FIRST_GOALS, PATIENCE_S)
            self._trap.spring(self)
            if not self._trap.is_synchronous:
                return list(self._holes())
            self._cell.node.kill()
            self.database.promote()
            self.database.server.wait_for_replicas('')
            self._cell.start_node(self._program)
            self._operator.gives_more = False
            self._operator.forget()
            ended = self.live(self._operator.is_done, PATIENCE_S)
            return [*self._faults(), *([] if ended else ['the order did not end'])]

    def live(self, until: Callable[[], bool], within_s: float) -> bool:
        """Let the line run; tell whether a condition has come true in time."""
        end = time.monotonic() + within_s

        def look() -> bool:
            self._operator.look()
            return until()

        while time.monotonic() < end:
            self._cell.watch.ros.spin_for(end - time.monotonic(), lambda: look() or self._mute)
            if until():
                return True
            if self._mute:
                self._cell.watch.connect_anew()
                self._operator.forget()
        return False

    def goes_on(self, goals: int = _MORE_GOALS) -> bool:
        """Wait until the node has ended, or so many more goals have begun; tell which."""
        wanted = self._goals + goals
        self.live(lambda: not self.lives or self._goals >= wanted, _GOES_ON_S)
        return self.lives

    @property
    def lives(self) -> bool:
        """Tell whether the node has not ended."""
        return self._cell.node.is_running

    @property
    def _goals(self) -> int:
        return len(self._cell.goals(event='started'))

    @property
    def _mute(self) -> bool:
        return self._operator.is_cut_off(node_lives=self.lives)

    def _faults(self) -> Iterator[str]:
        events = journal(self.database.rows)
        yield from judge(events, Controllers(self._cell.log), {}).faults
        kept = [json.loads(record) for _, record in self.database.rows()]
        yield from vanished(kept, self._cell.watch.events, 'the operator')

    def _holes(self) -> Iterator[str]:
        seqs = [seq for seq, _ in self.database.rows()]
        if seqs != list(range(1, len(seqs) + 1)):
            yield f'the journal goes on behind a hole: {len(seqs)} events up to {seqs[-1]}'


def without_check(trap: Trap, folder: Path) -> Path:
    """Copy the package without the check against a trap."""
    copy_package(folder)
    assert applies(HERE / f'{trap.patch}.patch', folder), trap.patch
    return folder


def rounds(folder: Path, trap: Trap, number: int, *, checked: bool) -> list[list[str]]:
    """Run a trap some times, and return what was lost each time."""
    with tempfile.TemporaryDirectory() as scratch:
        copy = None if checked else without_check(trap, Path(scratch))
        name = f'{trap.name}_{"with" if checked else "without"}'
        return [Round(folder / f'{name}_{n}', trap, n, copy).run() for n in range(number)]


# The traps.


def _seen_after_a_crash(at: Round) -> None:
    """Rows that nobody has confirmed are seen when the server is up again; no replica has them."""
    at.database.replica.stop(signal.SIGQUIT)
    at.live(lambda: at.database.is_waited_for, PATIENCE_S)
    at.database.strike('crash')
    at.goes_on()
    at.database.replica_returns_alone()


def _cancelled_wait(at: Round) -> None:
    """Somebody cancels the wait for the replica; the server reports success, and a warning."""
    at.database.replica.stop(signal.SIGQUIT)
    at.live(lambda: at.database.is_waited_for, PATIENCE_S)
    at.database.cancel_waits()
    at.goes_on(goals=1)
    at.database.replica_returns_alone()


def _answered_before_the_commit(at: Round) -> None:
    """The answer to a statement arrives, and its commit never happens."""
    at.live(at.database.strike('lost_commit'), PATIENCE_S)
    at.goes_on()


def _gap_after_a_promotion(at: Round) -> None:
    """An asynchronous replica without the last events takes over while the node lives."""
    at.database.replica.stop(signal.SIGQUIT)
    at.goes_on()
    at.database.replica_returns_alone()
    at.database.promote()
    at.goes_on()


TRAPS: Sequence[Trap] = (
    Trap(
        'rows_seen_after_a_crash',
        '9_1_rows_seen_after_a_lost_answer_wait_for_replicas',
        _seen_after_a_crash,
    ),
    Trap(
        'cancelled_wait',
        '9_1_a_wait_for_replicas_that_was_cancelled_fails',
        _cancelled_wait,
    ),
    Trap(
        'answer_before_the_commit',
        '9_1_a_commit_is_done_with_the_answer_of_the_server',
        _answered_before_the_commit,
    ),
    Trap(
        'gap_after_a_promotion',
        '9_1_an_append_leaves_no_gap',
        _gap_after_a_promotion,
        is_synchronous=False,
    ),
)
