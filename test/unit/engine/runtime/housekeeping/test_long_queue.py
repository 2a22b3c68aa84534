"""The state of a long queue is kept while the line goes on."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from fakes.commands import ControlJob
from fakes.journal_states import restored
from fakes.line import THREE
from fakes.long_journal import LongRun
from fakes.operator import ann
from fakes.virtual_run import snapshot

from bt_orchestrator.engine.runtime import housekeeping
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.keeping import state_text
from bt_orchestrator.model.keeping.snapshot import Writer


@pytest.fixture
def small_slices(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(state_text, 'SLICE', 10)


def queue_many(run: LongRun) -> None:
    script = run.line.script(THREE)
    jobs = tuple(Job(f'Q-{n}', script, 1) for n in range(55))
    assert run.orchestrator.ask(AddJobs(jobs)).accepted


def test_long_queue_state_is_written_in_slices(
    path: Path, often: None, small_slices: None, replays: list[int]
) -> None:
    run = LongRun(path)
    queue_many(run)
    begun = run.orchestrator.state.seq
    for turn in range(6):
        assert not list(run.store.snapshots()), turn
        run.housekeeping.turn(quiet=turn == 0)
        assert run.clock.advance()
        run.orchestrator.settle()
        if turn == 2:
            last = ControlJob('cancel', 'Q-54', ann())
            assert run.orchestrator.ask(last).accepted
    (kept_state,) = run.store.snapshots()
    state = run.orchestrator.state
    assert kept_state.seq == begun < state.seq
    assert len(state.queue) < 54
    run.kill()
    replays.clear()
    assert snapshot(restored(path)) == snapshot(state)
    assert len(replays) == state.seq - begun


def test_job_end_does_not_rewrite_long_queue(path: Path, often: None) -> None:
    run = LongRun(path)
    queue_many(run)
    run.rest(3)
    first = [entry.seq for entry in run.store.snapshots()]
    while len(run.orchestrator.state.ended) < 4:
        assert run.clock.advance()
        run.orchestrator.settle()
        run.rest(1)
        seqs = [entry.seq for entry in run.store.snapshots()]
        assert seqs[0] == first[0] or seqs[0] - first[0] > len(run.orchestrator.state.queue)
    assert len(seqs) == 2
    run.kill()


@pytest.mark.parametrize('is_forgetful', [False, True])
def test_long_queue_is_read_back_before_event_removal(
    path: Path,
    is_forgetful: bool,
    small_slices: None,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    run = LongRun(path)
    run.job('J1')
    run.housekeeping = housekeeping.Housekeeping(run.orchestrator.state, run.store, 0)
    queue_many(run)
    assert run.orchestrator.ask(ControlJob('hold', 'Q-40', ann())).accepted
    write_fields = Writer.write_fields

    def forgetful(writer: Writer, kind: type, value: Any) -> dict[str, Any]:
        fields = write_fields(writer, kind, value)
        fields.pop('held', None)
        return fields

    if is_forgetful:
        monkeypatch.setattr(Writer, 'write_fields', forgetful)
    run.rest(20)
    assert ('the state cannot be kept (job Q-40 would change)' in caplog.text) is is_forgetful
    assert (run.store.beginning() is None) is is_forgetful
    run.kill()
