"""The demo, from nothing to the summary, and that it leaves nothing behind."""

from __future__ import annotations

import re
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from program_process import PATIENCE_S, ProgramProcess

INTERRUPTED = 130


@pytest.fixture
def demo(tmp_path: Path) -> Iterator[ProgramProcess]:
    """Give a running demo, which is fast."""
    process = ProgramProcess(['demo', '--speed', '10'], tmp_path, 'demo')
    yield process
    process.kill()


def started_pids(demo: ProgramProcess) -> list[int]:
    return [int(pid) for pid in re.findall(r'^\[(\d+)\] .*ready', demo.output, re.MULTILINE)]


def is_there(pid: int) -> bool:
    return Path(f'/proc/{pid}').exists()


def test_the_demo_packs_its_order_and_leaves_nothing(demo: ProgramProcess) -> None:
    assert demo.wait(2 * PATIENCE_S) == 0, demo.errors
    # items, packed, rejected, missing, nonconforming
    assert re.search(r'^WO-1001 +reference_process( +3){2}( +0){3} ', demo.output, re.MULTILINE)
    demo.assert_clean()
    pids = started_pids(demo)
    assert len(pids) == 3
    assert [pid for pid in pids if is_there(pid)] == []


@pytest.mark.parametrize('with_signal', [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_demo_leaves_nothing(
    demo: ProgramProcess, with_signal: signal.Signals
) -> None:
    demo.wait_ready(' at /unpacking/unpacking_action')
    pids = started_pids(demo)
    assert [is_there(pid) for pid in pids] == [True] * 3
    demo.send(with_signal)

    assert demo.wait() == INTERRUPTED, demo.errors
    assert 'interrupted' in demo.output
    demo.assert_clean()
    assert [pid for pid in pids if is_there(pid)] == []
