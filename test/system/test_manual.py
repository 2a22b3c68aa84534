"""Manual mode of a real line: goals live as long as their panel, and over a kill of the node."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from cell_processes import SMALL_CELL, CellProcesses, StartCell, remembering, run_verb
from patience import PATIENCE_S

from bt_orchestrator.base.errors import NodeUnreachable
from bt_orchestrator.model.by import By, Known, Role
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.requests import ask
from bt_orchestrator.ros.link.ros_link import RosLink
from bt_orchestrator.script.users.file import UsersFile

EVE = By('eve', 'a door', 'to look at the gripper', Role.ENGINEER, Known.PAGE_PANEL)
LATE = ['worker.TASK_C#1=late:240']
"""The goal runs for 14 s, unless it is cancelled."""
LATER = ['worker.TASK_C#1=late:1200']
"""It runs for a minute: longer than any node takes to come back."""


def line_in_manual(
    start_cell: StartCell, folder: Path, late: Sequence[str] = LATE
) -> CellProcesses:
    users = UsersFile(folder / 'users.yaml')
    users.change_panel('address', '10.0.0.9', named=True)
    options = ['--trust-local-doors', '--users', str(folder / 'users.yaml')]
    cell = start_cell(
        remembering(SMALL_CELL),
        fail=[*late],
        run_options=[*options, '--journal', str(folder / 'journal.db'), '--auto-resume'],
    )
    cell.connect()
    return cell


class Panel:
    """Eve, at the panel of a door that the node believes."""

    def __init__(self, cell: CellProcesses) -> None:
        self._cell = cell
        self._link = RosLink('/bt_orchestrator', PATIENCE_S)

    def ask(self, name: str, **given: Any) -> Answer:
        """Make a request."""
        return self._link.ask(ask(name, EVE, **given))

    def enter(self) -> None:
        """Begin manual mode."""
        for name in ('cell.local', 'cell.manual'):
            answer = self.ask(name)
            assert answer.accepted, answer

    def stay(self, wanted: str, within_s: float = PATIENCE_S) -> None:
        """Be heard until the last goal is in a state."""
        until = time.monotonic() + within_s
        while True:
            goal = self._cell.watch.status.manual
            if goal.state == wanted:
                return
            assert time.monotonic() < until, goal
            try:
                self.ask('cell.at_panel')
            except NodeUnreachable:
                continue
            self._cell.watch.ros.spin_for(0.3)

    def close(self) -> None:
        """Go."""
        self._link.close()


def test_7_11_9_goal_survives_node_kill_while_panel_stays(
    start_cell: StartCell, tmp_path: Path
) -> None:
    cell = line_in_manual(start_cell, tmp_path)
    panel = Panel(cell)
    panel.enter()
    answer = panel.ask('component.run_task', component='worker', task='TASK_C')
    assert answer.accepted, answer
    panel.stay('running')
    cell.watch.ros.spin_until(lambda: cell.goals(event='started', component='worker'), 'the goal')
    cell.node.kill()
    cell.start_node()
    cell.node.wait_ready()
    panel.stay('running')
    panel.stay('done')
    cell.watch.until('task.adopted', task='manual')
    (ended,) = cell.goals(event='ended', component='worker')
    assert ended['status'] == 'succeeded'
    assert cell.watch.seen('task.cancel_requested') == []
    status, output, _ = run_verb(cell.folder, 'status')
    assert (status, 'in manual' in output) == (0, True), output
    status, _, errors = run_verb(cell.folder, 'cell', 'reset', '--reason', 'why not')
    assert (status, 'which is in local' in errors) == (1, True), errors

    cell.run_small(quantity=1)
    assert panel.ask('job.release', job='WO-1').accepted
    cell.watch.ros.spin_for(1.0)
    assert cell.watch.status.state == 'Stopped'
    shown = cell.watch.status.seq
    assert panel.ask('cell.production', as_shown=shown).accepted
    cell.watch.until_status(lambda view: 'reset' in view.commands, 'production')
    assert panel.ask('cell.reset').accepted
    cell.watch.until_status(lambda view: 'start' in view.commands, 'Idle')
    assert panel.ask('cell.start').accepted
    assert cell.watch.until_ended('WO-1').packed == 1
    panel.close()
    cell.stop()


def test_7_11_9_goal_ends_after_node_kill_without_panel(
    start_cell: StartCell, tmp_path: Path
) -> None:
    cell = line_in_manual(start_cell, tmp_path, LATER)
    panel = Panel(cell)
    panel.enter()
    assert panel.ask('component.run_task', component='worker', task='TASK_C').accepted
    panel.stay('running')
    cell.watch.ros.spin_until(lambda: cell.goals(event='started', component='worker'), 'the goal')
    panel.close()
    cell.node.kill()
    cell.start_node()
    cell.node.wait_ready()
    cancelled = cell.watch.until('task.cancel_requested', task='manual')
    assert cancelled['cause'] == 'panel_lost'
    cell.watch.until_status(lambda view: view.manual.state == 'canceled', 'the end of the goal')
    (ended,) = cell.goals(event='ended', component='worker')
    assert ended['status'] == 'canceled'
    cell.stop()


def test_7_11_3_verb_is_refused_away_from_panel(start_cell: StartCell, tmp_path: Path) -> None:
    cell = line_in_manual(start_cell, tmp_path)
    panel = Panel(cell)
    panel.enter()
    verb = ('component', 'run-task', 'worker', 'TASK_A', '--reason', 'to look')
    status, _, errors = run_verb(cell.folder, *verb)
    assert (status, 'is at none' in errors) == (1, True), errors
    assert cell.goals(event='started') == []
    panel.close()
    cell.stop()
