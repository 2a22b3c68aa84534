"""Journals that nodes of an older program left: read, taken over, and gone on with.

How they were made stands in the README beside them.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from fakes.action_types import FakeActionTypes
from fakes.commands import AnswerHold, ControlJob, Resume
from fakes.journal_reading import journal_reading
from fakes.operator import ann

from bt_orchestrator.engine.runtime.housekeeping import Housekeeping
from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.engine.runtime.recovery import restore
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.state import CellState, Phase
from bt_orchestrator.script.cell_file import read_cell
from bt_orchestrator.script.script_file import read_script
from bt_orchestrator.sim.gateway import VirtualClock, VirtualGateway
from bt_orchestrator.store.sqlite.store import SqliteStore

FOLDER = Path(__file__).parents[3] / 'data' / 'journals_schema_2'
TYPES = FakeActionTypes()
CELL = read_cell(FOLDER / 'cell.yaml', TYPES)
QUICK = read_script(FOLDER / 'quick.yaml', CELL, TYPES)

KILLED_AT = 184
"""The last event that the killed node committed."""


@pytest.fixture
def journals(tmp_path: Path) -> Path:
    shutil.unpack_archive(FOLDER / 'journals.tar.gz', tmp_path)
    return tmp_path


@pytest.fixture
def killed(journals: Path) -> Path:
    return journals / 'killed' / 'journal.sqlite3'


@pytest.fixture
def retention(journals: Path) -> Path:
    return journals / 'retention' / 'journal.sqlite3'


def restored(path: Path) -> CellState:
    store = SqliteStore(path)
    try:
        return restore(CELL, store)
    finally:
        store.close()


def packed(state: CellState) -> dict[str, int]:
    return {name: job.progress.packed for name, job in state.ended.items()}


class NextNode:
    """The program of today with such a journal, on virtual robots that know no goal of it."""

    def __init__(self, path: Path) -> None:
        self.store = SqliteStore(path)
        self.clock = VirtualClock(restore(CELL, self.store).time + 60.0)
        gateway = VirtualGateway(CELL, TYPES, self.clock)
        self.orchestrator = Orchestrator(CELL, gateway, self.clock, self.store, auto_resume=True)
        self.state = self.orchestrator.state

    def finish(self) -> None:
        """Let time pass until every job has ended; Ann has looked at the line."""
        self.orchestrator.settle()
        while self.state.jobs:
            for hold in list(self.state.holds.values()):
                by = ann('looked at it')
                asked = Resume(by, hold.id) if hold.is_pause else AnswerHold(hold.id, 'skip', by)
                assert self.orchestrator.ask(asked).accepted
            assert self.clock.advance()
            self.orchestrator.settle()

    def close(self) -> None:
        Housekeeping(self.state, self.store).finish()
        self.orchestrator.close()
        self.store.close()


def test_what_the_killed_node_had_done_is_there(killed: Path) -> None:
    state = restored(killed)
    assert state.seq == KILLED_AT
    assert state.packml is PackmlState.HOLDING
    assert packed(state) == {'WO-1': 2, 'WO-2': 1}
    live = {name: (job.job.quantity, job.held) for name, job in state.jobs.items()}
    assert live == {'WO-3': (4, False), 'WO-4': (2, False), 'WO-5': (1, True)}
    assert [name for name, job in state.jobs.items() if job.started_at] == ['WO-3']
    places = {name: item.section for name, item in state.items.items()}
    assert places == {'WO-3/1': 3, 'WO-3/2': 2, 'WO-3/3': 1}
    assert {name: flag.count for name, flag in state.flags.items()} == {'worked': 1}
    (running,) = state.running.items()
    assert (running[0].item, running[0].task) == ('WO-3/1', 'bake')
    assert running[1].args == {'special_argument_2': 0.0}
    assert running[1].server is not None
    held, pause = state.holds.values()
    assert (held.item, held.task, held.reason) == ('WO-3/2', 'work', 'aborted')
    assert held.key is not None
    assert state.tasks[held.key].phase is Phase.HELD
    assert (pause.reason, pause.owner) == ('paused', 'Ann')


def test_current_node_continues_older_killed_node(killed: Path) -> None:
    node = NextNode(killed)
    assert node.orchestrator.ask(ControlJob('release', 'WO-5', ann('now'))).accepted
    node.finish()
    assert packed(node.state) == {'WO-1': 2, 'WO-2': 1, 'WO-3': 4, 'WO-4': 2, 'WO-5': 1}
    assert node.state.packml is PackmlState.COMPLETE
    node.close()
    with journal_reading(killed) as reader:
        done = {job.job: job.counts.packed for job in reader.summaries()}
        assert [seq for seq, _ in reader.each(Wanted())] == list(range(1, node.state.seq + 1))
    assert done == packed(node.state)


def test_work_before_retention_is_known_by_its_result(retention: Path) -> None:
    state = restored(retention)
    assert (state.seq, state.packml) == (216, PackmlState.STOPPED)
    assert packed(state) == {'A-1': 2, 'A-2': 2, 'A-3': 2}
    with journal_reading(retention) as reader:
        assert reader.records.extent().first_seq == 146
        summaries = [(job.job, job.status, job.counts.packed) for job in reader.summaries()]
    assert summaries == [(name, 'completed', 2) for name in ('A-1', 'A-2', 'A-3')]


def test_a_journal_with_retention_is_gone_on_with(retention: Path) -> None:
    node = NextNode(retention)
    refused = node.orchestrator.ask(AddJobs((Job('A-1', QUICK, 1),)))
    assert 'A-1' in refused.message
    assert not refused.accepted
    assert node.orchestrator.ask(AddJobs((Job('A-4', QUICK, 3),))).accepted
    node.finish()
    assert packed(node.state)['A-4'] == 3
    node.close()
    assert restored(retention).seq == node.state.seq
