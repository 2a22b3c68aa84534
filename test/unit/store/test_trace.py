"""Traces in files."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from bt_orchestrator.model.events import BeatStarted
from bt_orchestrator.store.trace import TraceFile, UnusableTrace


def test_events_reach_the_file_when_published(tmp_path: Path) -> None:
    path = tmp_path / 'trace.jsonl'
    with TraceFile(path) as trace:
        trace.publish([BeatStarted(seq=1, beat=2, time=1.5)])

        lines = path.read_text().splitlines()

    assert [json.loads(line) for line in lines] == [
        {'seq': 1, 'time': 1.5, 'event': 'beat.started', 'beat': 2}
    ]


def test_an_older_trace_is_replaced(tmp_path: Path) -> None:
    path = tmp_path / 'trace.jsonl'
    path.write_text('old\n')
    with TraceFile(path):
        pass

    assert path.read_text() == ''


def test_a_file_that_cannot_be_opened_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UnusableTrace, match=r'cannot write the trace .*: '):
        TraceFile(tmp_path / 'missing' / 'trace.jsonl')


@pytest.mark.skipif(not Path('/dev/full').exists(), reason='needs a device that is always full')
def test_a_full_disk_is_told_at_the_end() -> None:
    trace = TraceFile(Path('/dev/full'))
    trace.publish([BeatStarted(beat=2)])
    trace.publish([BeatStarted(beat=3)])

    with pytest.raises(UnusableTrace, match='/dev/full'):
        trace.__exit__(None, None, None)
