"""A process that answers: late, dead, in the way of nobody, and gone with the one that asks."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from patience import until

from bt_orchestrator.base.child_process import ChildFailed, ChildProcess, ChildTooLate

LONGEST_S = 40.0


@pytest.fixture(autouse=True)
def _path(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('PYTHONPATH', os.pathsep.join(sys.path))


@pytest.fixture
def child() -> Iterator[ChildProcess]:
    process = ChildProcess('fakes.asked_child', b'begin')
    yield process
    process.close()


def is_gone(pid: int) -> bool:
    """Tell whether a process has ended; one that nobody has waited for yet has."""
    try:
        stat = Path(f'/proc/{pid}/stat').read_text()
    except FileNotFoundError:
        return True
    return stat.rpartition(') ')[2].startswith('Z')


def until_gone(pid: int) -> None:
    until(lambda: is_gone(pid), f'the end of {pid}', LONGEST_S)


def test_one_process_answers_questions_of_every_size(child: ChildProcess) -> None:
    answers = [child.ask(b'x' * size) for size in (0, 1, 70_000, 5_000_000)]
    pid = child.pid
    assert [len(answer) for answer in answers] == [0, 1, 70_000, 5_000_000]
    assert child.ask(b'again') == b'again'
    assert child.pid == pid


def test_it_lets_others_come_first(child: ChildProcess) -> None:
    assert int(child.ask(b'nice')) >= min(19, os.nice(0) + 3)


def test_what_it_prints_is_no_answer(child: ChildProcess) -> None:
    assert child.ask(b'print') == b'print'


def test_late_child_is_killed_and_replaced(
    child: ChildProcess,
) -> None:
    child.ready()
    pid = child.pid
    assert pid is not None
    with pytest.raises(ChildTooLate):
        child.ask(b'compute', within_s=0.2)
    assert is_gone(pid)
    assert child.ask(b'next') == b'next'
    assert child.pid != pid


def test_stopped_child_raises_too_late(child: ChildProcess) -> None:
    child.ready()
    assert child.pid is not None
    os.kill(child.pid, signal.SIGSTOP)
    with pytest.raises(ChildTooLate):
        child.ask(b'x' * 5_000_000, within_s=0.2)  # more than a pipe takes


def test_dead_child_is_reported_and_replaced(child: ChildProcess) -> None:
    with pytest.raises(ChildFailed, match='the process ended by signal SIGKILL'):
        child.ask(b'die')
    assert child.ask(b'next') == b'next'
    assert child.pid is not None
    os.kill(child.pid, signal.SIGKILL)
    until_gone(child.pid)
    with pytest.raises(ChildFailed, match='SIGKILL'):
        child.ask(b'next')
    assert child.ask(b'next') == b'next'


def test_one_that_cannot_be_started_is_told(
    child: ChildProcess, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(sys, 'executable', '/no/python')
        with pytest.raises(ChildFailed, match='the process cannot be started: '):
            child.ask(b'question')
    assert child.ask(b'question') == b'question'


def test_closing_ends_a_question_that_is_being_answered(child: ChildProcess) -> None:
    child.ready()
    errors: list[str] = []

    def ask() -> None:
        try:
            child.ask(b'compute')
        except ChildFailed as error:
            errors.append(str(error))

    asking = threading.Thread(target=ask)
    asking.start()
    child.close()
    asking.join(LONGEST_S)
    assert len(errors) == 1
    with pytest.raises(ChildFailed, match='it was closed meanwhile'):
        child.ask(b'question')


def test_child_ends_with_parent_during_answer() -> None:
    words = [sys.executable, '-c', 'from fakes.asked_child import ask_and_wait; ask_and_wait()']
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout is not None
        pid = int(parent.stdout.readline())
        parent.kill()
    until_gone(pid)
