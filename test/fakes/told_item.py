"""An item with a story: retries, a hold, a restart of the node in the middle of it, a reject."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path

from fakes.commands import AnswerHold, Resume
from fakes.line import Line
from fakes.operator import ann, engineer
from fakes.world import World

from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.model import events as e
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.store.sqlite.store import SqliteStore

ITEM = 'WO-7/2'
"""The one with the story."""

BEGIN = 1_779_030_000.0
"""The day of the run, seconds since the epoch."""

SCRIPT = """
params: {torque: {type: float, default: 2.5}, grease: {type: str}}
lots: {grease: "${params.grease}"}
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2:
    - {id: press, @a2, retries: 1, retry_delay: 2.0, args: {special_argument_1: "deep"}}
    - parallel: [{id: screw_left, @b2}, {id: screw_right, @arm}]
  3:
    - {id: weigh, @arm.TASK_B, fails_unless: {value: "${results.weigh.measurement}", at_most: 5.0},
       on_failure: reject}
    - {id: pack, @a3, qty_change: -1, runs_for: all}
"""


class ToldItem:
    """A job of three items; the second one fails twice, is held, and is found too heavy."""

    def __init__(self) -> None:
        self.line = Line(
            3,
            faults={'a2': 'TASK_A#2=abort TASK_A#3=abort', 'arm': 'TASK_B#2=reads:7.5'},
            seconds={'b2': 3.0},
        )
        parts = self.line.cell.components
        remembering = {name: replace(part, result_timeout_s=60.0) for name, part in parts.items()}
        self.line.cell = replace(self.line.cell, components=remembering)
        self.world = World(self.line.cell)
        self.world.clock.sleep(1.0)
        self.world.clock.ahead_s = BEGIN
        script = self.line.script(SCRIPT, 'gear')
        first = self.world.orchestrator()
        params = {'torque': 2.5, 'grease': 'L-77'}
        assert first.ask(AddJobs((Job('WO-7', script, 3, params),))).accepted
        self._go_until_held(first)
        self.world.clock.sleep(41.0)
        first.settle()
        (hold,) = first.state.holds
        assert first.ask(AnswerHold(hold, 'retry', ann('the part sat askew'))).accepted
        self.world.go_until_runs(first, 'press')
        first.close()
        self.world.clock.sleep(12.0)
        second = self.world.orchestrator(auto_resume=False)
        self.world.go(second)
        (hold,) = second.state.holds
        self.world.clock.sleep(20.0)
        ben = engineer('Ben', 'the panel', 'belt and gripper looked at')
        assert second.ask(Resume(ben, hold=hold)).accepted
        self.world.go(second)
        assert not second.state.jobs
        second.close()

    @property
    def events(self) -> Sequence[e.Event]:
        """Everything that happened."""
        return list(self.world.store.read())

    def write(self, path: Path) -> Path:
        """Write the journal to a file."""
        with closing(SqliteStore(path)) as store:
            store.append(self.events)
        return path

    def _go_until_held(self, orchestrator: Orchestrator) -> None:
        while not orchestrator.state.holds:
            orchestrator.settle()
            assert orchestrator.state.holds or self.world.clock.advance()
