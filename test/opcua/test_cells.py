"""All 88 cells of ISA-95 Job Control, method by state, at a node that runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import pytest
from cell_processes import small_script
from opcua.conftest import StartLine
from opcua.line import ORDERS, Line, job_order
from tables.standard import GONE, NONE, Cell, read_table

from bt_orchestrator.model.jobs.job_control import METHODS

HELD, SUSPENDED = 'Interrupted/Held', 'Interrupted/Suspended'
WITH_ORDER = ('Store', 'StoreAndStart', 'Update')

STANDARD = read_table()

OURS: Mapping[tuple[str, str], Cell] = {**STANDARD, ('Resume', HELD): Cell(8, '')}
"""What the product answers: a hold needs an answer, and `Resume` is none. Stop and Abort differ in
time alone: the answer is 1 at once, and the state follows when the line has drained."""

ANSWERS = ('reject', 'skip', 'mark_done')
"""Of those that a hold takes the first; the others would try the task again."""


class Jobs:
    """Brings one job after the other into a state, as people and the MES would."""

    def __init__(self, line: Line) -> None:
        self._line = line
        self._number = 0
        self._scripts: dict[str, str] = {}
        for name, task in (('good', 'TASK_A'), ('slow', 'TASK_C'), ('bad', 'TASK_B')):
            text = small_script(name, task=task)
            # Rejected items are packed too: they leave the belt without a person.
            line.cell.script(text.replace('qty_change: -1', 'qty_change: -1, runs_for: all'), name)
        self.mes = line.client('engineer')
        self.mes.do('subscribe', values=[ORDERS])
        self._ways: Mapping[str, Callable[[str], object]] = {
            NONE: lambda order: None,
            'NotAllowedToStart': lambda order: self._must('Store', job_order(order, 'good')),
            'AllowedToStart': lambda order: self._start(order, 'good'),
            'Running': self._run,
            HELD: lambda order: self._start(order, 'bad'),
            SUSPENDED: self._suspend,
            'Ended': lambda order: self._start(order, 'good'),
            'Aborted': self._abort,
        }

    def bring(self, state: str) -> str:
        """Return the id of a new job that is in a state now."""
        self._number += 1
        order = f'WO-{self._number}'
        self._ways[state](order)
        if state != NONE:
            self.mes.wait_state(order, state)
        return order

    def call(self, method: str, order: str) -> int:
        """Call a method for a job, without a mistake in the call."""
        script = self._scripts.get(order, 'good')
        return self.mes.status(
            method, job_order(order, script, 2) if method in WITH_ORDER else order
        )

    def cleared(self, order: str) -> None:
        """Have a job end, whatever its state."""
        if (state := self.mes.states.get(order)) not in (None, 'Ended', 'Aborted'):
            self._must('Abort', order)
            self.wait_drained(order, 'Aborted')
        if state is not None:
            self._must('Clear', order)
            self.mes.wait_state(order, GONE)

    def wait_drained(self, order: str, state: str) -> None:
        """Wait until a job has ended, and answer whatever the line asks for meanwhile."""
        watch = self._line.cell.watch
        self.mes.wait_state(order, state, HELD)
        while self.mes.states[order] != state:
            watch.ros.spin_until(
                lambda: watch.status.holds or self.mes.told_state(order) == state,
                f'{order} to be {state}, or a hold',
            )
            for hold in watch.status.holds:
                word = next((word for word in ANSWERS if word in hold.answers), None)
                if word is None:  # an item whose packing was skipped may not leave the belt
                    watch.remove(hold.item)
                else:
                    watch.answer(hold.id, word)

    def command(self, verb: str) -> None:
        """Command the cell as a person at the line does."""
        status, _, errors = self._line.cell.verb(verb, '--reason', 'a test')
        assert status == 0, errors

    def _start(self, order: str, script: str, runs: int = 1) -> None:
        self._scripts[order] = script
        self._must('StoreAndStart', job_order(order, script, runs))

    def _run(self, order: str) -> None:
        """Have a job at work that does not end by itself, and may be aborted.

        A goal that places an item and is cancelled would wait for somebody who looks.
        """
        self._start(order, 'slow', 60)
        self._line.cell.watch.until('task.succeeded', 2, job=order, task='feed')

    def _suspend(self, order: str) -> None:
        self._run(order)
        self._must('Pause', order)

    def _abort(self, order: str) -> None:
        self._must('Store', job_order(order, 'good'))
        self._must('Abort', order)

    def _must(self, method: str, what: object) -> None:
        assert self.mes.status(method, what) == 1


@pytest.fixture
def jobs(start_line: StartLine) -> Jobs:
    # Bad ones wait for an answer at once: a failure after the nominal time would take a minute.
    return Jobs(start_line(fail=['worker.TASK_B#*=reject']))


@pytest.mark.long
def test_every_table_cell_answers_and_acts_as_documented(jobs: Jobs) -> None:
    jobs.command('pause')  # what may start waits, until its cells are tried
    for state in (NONE, 'NotAllowedToStart', 'AllowedToStart'):
        _try_row(jobs, state)
    jobs.command('resume')
    for state in ('Running', HELD, SUSPENDED, 'Ended', 'Aborted'):
        _try_row(jobs, state)
    assert len(STANDARD) == 88


def _try_row(jobs: Jobs, state: str) -> None:
    """Try all methods in one state: those that fail on one job, the others on one each."""
    cells = {method.name: OURS[method.name, state] for method in METHODS}
    refused = jobs.bring(state)
    for method, cell in cells.items():
        if cell.status != 1:
            assert (method, jobs.call(method, refused)) == (method, cell.status)
            now = jobs.mes.states.get(refused, NONE)
            assert (method, now) == (method, state), 'a failed call changes nothing'
    jobs.cleared(refused)
    for method, cell in cells.items():
        if cell.status == 1:
            order = jobs.bring(state)
            assert (method, jobs.call(method, order)) == (method, 1)
            if cell.after in ('Ended', 'Aborted'):
                jobs.wait_drained(order, cell.after)
            else:
                jobs.mes.wait_state(
                    order, SUSPENDED if cell.after == 'Interrupted' else cell.after
                )
            jobs.cleared(order)
