"""The demo, from nothing to the summary, and that it leaves nothing behind."""

from __future__ import annotations

import json
import os
import re
import signal
from collections.abc import Iterator, Sequence
from http.client import HTTPConnection
from pathlib import Path

import pytest
from fakes.opcua_access import with_login
from opcua_reader import reading
from patience import PATIENCE_S
from program_process import DEMO_PACKED, ProgramProcess

from bt_orchestrator.cli.demo.folder import stop_process
from bt_orchestrator.cli.demo.programs import NAME, PASSWORD

INTERRUPTED = 130

COMPLETED = r'^ *(\S+) s  WO-1001 completed'
FINISHED = DEMO_PACKED + r'.* (\S+) s$'
"""When, as the events say and as the summary says."""

FIRST_TASK = ' at /unpacking/unpacking_action'


@pytest.fixture
def demo(tmp_path: Path) -> Iterator[ProgramProcess]:
    """Give a running demo, which is fast."""
    process = ProgramProcess(['demo', '--speed', '10'], tmp_path, 'demo')
    yield process
    process.kill()
    for pid in started_pids(process):
        stop_process(pid)


def started_pids(demo: ProgramProcess) -> list[int]:
    return [int(pid) for pid in re.findall(r'^\[(\d+)\] .*ready', demo.output, re.MULTILINE)]


def resumed(folder: Path) -> ProgramProcess:
    return ProgramProcess(['demo', '--resume', '--speed', '10'], folder, 'demo_resumed')


def assert_finished(again: ProgramProcess, pids: Sequence[int]) -> None:
    assert again.wait(2 * PATIENCE_S) == 0, again.errors
    assert re.search(DEMO_PACKED, again.output), again.output
    assert [pid for pid in [*pids, *started_pids(again)] if is_there(pid)] == []


def is_there(pid: int) -> bool:
    """Tell whether a process runs; one that has ended may wait for its parent to take note."""
    stat = Path(f'/proc/{pid}/stat')
    return stat.exists() and stat.read_text().rpartition(')')[2].split()[0] != 'Z'


@pytest.mark.every_distro
def test_the_demo_packs_its_order_and_leaves_nothing(demo: ProgramProcess) -> None:
    assert demo.wait(2 * PATIENCE_S) == 0, demo.errors
    summary, line = (re.search(p, demo.output, re.MULTILINE) for p in (FINISHED, COMPLETED))
    assert summary is not None
    assert line is not None
    assert 'starting controllers 1, controllers 2, tree node\n' in demo.output
    assert float(summary[2]) == pytest.approx(float(line[1]), abs=0.1), 'both from the order on'
    demo.assert_clean()
    pids = started_pids(demo)
    assert len(pids) == 3
    assert [pid for pid in pids if is_there(pid)] == []


def test_demo_with_page_and_opcua_runs_until_interrupted(tmp_path: Path) -> None:
    words = ['demo', '--speed', '10', '--page', '0', '--opcua', '0']
    demo = ProgramProcess(words, tmp_path, 'demo')
    try:
        demo.wait_ready('WO-1001 completed')
        pids = started_pids(demo)
        assert [is_there(pid) for pid in pids] == [True] * 5
        address = re.search(r'page ready: http://([^/]+)/', demo.output)
        assert address is not None
        connection = HTTPConnection(address[1], timeout=PATIENCE_S)
        connection.request('GET', '/healthz')
        assert json.loads(connection.getresponse().read())['node'] == '/bt_orchestrator'
        connection.close()
        endpoint = re.search(r'opcua ready: (opc\.tcp://\S+) shows /bt_orchestrator', demo.output)
        assert endpoint is not None
        url = with_login(endpoint[1], NAME, PASSWORD)
        reading(url, lambda reader: reader.wait('Simple/LastJob/ID', 'WO-1001'.__eq__))
        demo.send(signal.SIGINT)
        assert demo.wait() == 0, demo.errors
        assert re.search(DEMO_PACKED, demo.output), demo.output
        demo.assert_clean()
        assert [pid for pid in pids if is_there(pid)] == []
    finally:
        demo.stop()


@pytest.mark.every_distro
@pytest.mark.parametrize('with_signal', [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_demo_leaves_nothing(
    demo: ProgramProcess, with_signal: signal.Signals
) -> None:
    demo.wait_ready(FIRST_TASK)
    pids = started_pids(demo)
    assert [is_there(pid) for pid in pids] == [True] * 3
    demo.send(with_signal)

    assert demo.wait() == INTERRUPTED, demo.errors
    assert 'interrupted' in demo.output
    demo.assert_clean()
    assert [pid for pid in pids if is_there(pid)] == []


@pytest.mark.every_distro
def test_killed_demo_resumes_and_finishes_its_order(demo: ProgramProcess, tmp_path: Path) -> None:
    demo.wait_ready(FIRST_TASK)
    pids = started_pids(demo)
    demo.kill()
    assert [is_there(pid) for pid in pids] == [True] * 3, 'they go on, as other computers would'

    again = resumed(tmp_path)
    assert_finished(again, pids)
    assert again.output.count('still runs') == 3


def test_demo_resumes_after_kill_of_tree_node(demo: ProgramProcess, tmp_path: Path) -> None:
    demo.wait_ready(FIRST_TASK)
    *controllers, node = started_pids(demo)
    os.kill(node, signal.SIGKILL)
    assert demo.wait() == 1
    assert re.search(r'take over with: \S*bt-orchestrator demo --resume ', demo.errors)
    assert [is_there(pid) for pid in controllers] == [True] * 2

    again = resumed(tmp_path)
    assert_finished(again, controllers)
    assert again.output.count('still runs') == 2


def test_resume_without_killed_demo_is_refused(tmp_path: Path) -> None:
    again = resumed(tmp_path)
    assert again.wait() == 1
    assert 'there is no demo to resume' in again.errors


@pytest.mark.parametrize(
    ('wrong', 'message'),
    [
        (['--fail', 'componnt_3a.#1=abort'], 'did you mean `component_3a`'),
        (['--fail', 'component_3a.#1=abrt'], 'one of false, reject, abort'),
        (['--speed', '0'], 'expected a number greater than 0'),
        (['--order', 'no_such.yaml'], 'no_such.yaml'),
        (['--cell', 'no_such.yaml'], 'no_such.yaml'),
    ],
)
def test_wrong_options_are_reported_before_anything_starts(
    wrong: Sequence[str], message: str, tmp_path: Path
) -> None:
    demo = ProgramProcess(['demo', *wrong], tmp_path, 'demo')
    assert demo.wait() in (1, 2)
    assert message in demo.errors
    assert demo.output == ''
    assert not (tmp_path / 'bt_orchestrator').exists(), 'the last demo is left as it is'


def test_hold_waits_for_printed_command_or_ends_demo(tmp_path: Path) -> None:
    held = ['demo', '--speed', '10', '--fail', 'component_3a.#1=abort']
    demo = ProgramProcess(held, tmp_path, 'demo')
    try:
        demo.wait_ready('HOLD 1: section 4, 4.1 (TASK_A) of WO-1001/1 at component_3a')
        demo.wait_ready('bt-orchestrator answer 1 retry --reason "WHY"')
        answer = ProgramProcess(
            ['answer', '1', 'retry', '--reason', 'in a test'], tmp_path, 'answer'
        )
        assert answer.wait() == 0, answer.errors
        assert demo.wait(2 * PATIENCE_S) == 0, demo.errors
    finally:
        demo.send(signal.SIGTERM)
        demo.wait()
    ended = ProgramProcess([*held, '--on-hold', 'end'], tmp_path, 'ended')
    assert ended.wait(2 * PATIENCE_S) == 1
    assert ended.output.count('hold 1: section 4') == 1


def test_node_killed_before_first_report_is_noticed_immediately(tmp_path: Path) -> None:
    demo = ProgramProcess(['demo', '--speed', '10'], tmp_path, 'demo')
    demo.wait_ready('tree node ready')
    *controllers, node = started_pids(demo)
    os.kill(node, signal.SIGKILL)
    assert demo.wait() == 1
    assert 'the tree node has gone' in demo.errors
    for pid in controllers:
        stop_process(pid)
