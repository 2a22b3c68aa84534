"""A process of low priority that answers questions, one after another.

It shares nothing with the process that asks: if it is slow or crashes, the caller goes on. Each
question and each answer is sent as its length followed by its bytes. The first question sets the
process up; its answer says that it is ready.
"""

from __future__ import annotations

import contextlib
import math
import os
import queue
import resource
import select
import signal
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

from bt_orchestrator.base.errors import OrchestratorError

START_WITHIN_S = 30.0
"""Longest time until a new process is ready, on a busy machine."""

FAREWELL_S = 2.0
"""Longest wait for the end of a process that was killed."""

MOST_MEMORY = 4 << 30
"""Limit of the process's address space, bytes; more than this is a defect."""

FIRST_TO_GO = b'800'
"""If memory runs out, the kernel ends this process before the one that asks."""

_LENGTH = struct.Struct('!Q')
_MOST_AT_ONCE = 1 << 20


class ChildFailed(OrchestratorError):
    """The process cannot be started, or ended without an answer."""


class ChildTooLate(ChildFailed):
    """No answer came in time, and the process was ended."""


def framed(message: bytes) -> bytes:
    """Return a question or an answer in the form for the pipe."""
    return _LENGTH.pack(len(message)) + message


class ChildProcess:
    """Sends questions to a module's process; the next question restarts one that ended.

    All methods except `close` are called from one thread.
    """

    def __init__(self, module: str, setup: bytes) -> None:
        """Prepare; nothing is started yet.

        :param module: a program that calls `be_modest` and `serve`
        :param setup: the first question to each process
        """
        self._module = module
        self._setup = setup
        self._process: subprocess.Popen[bytes] | None = None
        self._closing = threading.Lock()
        self._asking = threading.Lock()
        self._closed = False

    @property
    def pid(self) -> int | None:
        """Process id; None: there is no process."""
        return None if self._process is None else self._process.pid

    def ready(self) -> None:
        """Start the process if there is none.

        :raises ChildFailed: it cannot be started
        :raises ChildTooLate: it is not ready in time
        """
        if self._process is None:
            self._start()
            self._exchange(self._setup, START_WITHIN_S)

    def ask(self, question: bytes, within_s: float = math.inf) -> bytes:
        """Return the answer to a question.

        :param within_s: longest time from when the process is ready
        :raises ChildFailed: it cannot be started, or ended
        :raises ChildTooLate: it has not answered in time
        """
        self.ready()
        return self._exchange(question, within_s)

    def close(self) -> None:
        """End the process for good; may be called from any thread."""
        with self._closing:
            self._closed = True
            process = self._process
        if process is None:
            return
        process.kill()  # a thread that waits for its answer sees that it has ended
        if self._asking.acquire(timeout=FAREWELL_S):
            _end(process)
            self._asking.release()

    def _start(self) -> None:
        with self._closing:
            if self._closed:
                raise ChildFailed('it was closed meanwhile')
            try:
                self._process = subprocess.Popen(
                    [sys.executable, '-m', self._module],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    bufsize=0,
                    start_new_session=True,  # Ctrl-C is for the parent, which ends this one itself
                )
            except (OSError, MemoryError) as error:
                raise ChildFailed(f'the process cannot be started: {error}') from error
            for pipe in (self._process.stdin, self._process.stdout):
                assert pipe is not None
                os.set_blocking(pipe.fileno(), False)

    def _exchange(self, question: bytes, within_s: float) -> bytes:
        with self._asking:
            return self._exchange_alone(question, within_s)

    def _exchange_alone(self, question: bytes, within_s: float) -> bytes:
        process = self._process
        assert process is not None
        try:
            return _Exchange(process, time.monotonic() + within_s).answer(framed(question))
        except ChildTooLate:
            self._give_up(process)
            raise
        except (OSError, EOFError) as error:
            raise ChildFailed(f'the process ended {self._give_up(process)}') from error

    def _give_up(self, process: subprocess.Popen[bytes]) -> str:
        """End a process that failed, and say how it ended."""
        _end(process)
        self._process = None
        code = process.returncode
        if code is None:
            return 'not even when it was killed'
        return f'by signal {_signal_name(-code)}' if code < 0 else f'with exit status {code}'


class _Exchange:
    """One question and its answer, through non-blocking pipes."""

    def __init__(self, process: subprocess.Popen[bytes], until: float) -> None:
        assert process.stdin is not None
        assert process.stdout is not None
        self._to, self._from = process.stdin.fileno(), process.stdout.fileno()
        self._until = until
        self._got = bytearray()

    def answer(self, question: bytes) -> bytes:
        left = memoryview(question)
        while (size := self._size()) is None or len(self._got) < size:
            for ready, _ in self._wait(writes=bool(left)):
                if ready == self._from:
                    self._take()
                else:
                    left = left[os.write(self._to, left[:_MOST_AT_ONCE]) :]
        return bytes(self._got[_LENGTH.size : size])

    def _size(self) -> int | None:
        """Return the size of the answer with its length prefix, bytes; None: not known yet."""
        if len(self._got) < _LENGTH.size:
            return None
        return _LENGTH.size + int(_LENGTH.unpack_from(self._got)[0])

    def _take(self) -> None:
        data = os.read(self._from, _MOST_AT_ONCE)
        if not data:
            raise EOFError
        self._got += data

    def _wait(self, *, writes: bool) -> list[tuple[int, int]]:
        poll = select.poll()
        poll.register(self._from, select.POLLIN)
        if writes:
            poll.register(self._to, select.POLLOUT)
        left_s = self._until - time.monotonic()
        ready = poll.poll(None if left_s == math.inf else max(0.0, left_s * 1000))
        if not ready:
            raise ChildTooLate('no answer in time')
        return ready


def _end(process: subprocess.Popen[bytes]) -> None:
    process.kill()
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            pipe.close()
    # If it hangs in a disk access, it ends when the disk answers.
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(FAREWELL_S)


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return str(number)


# --- in the process -------------------------------------------------------------------------


def be_modest(nice: int) -> None:
    """Give this process the lowest priority; called before anything is loaded.

    :param nice: 19 uses only idle processor time
    """
    os.nice(nice)
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    most = MOST_MEMORY if hard == resource.RLIM_INFINITY else min(hard, MOST_MEMORY)
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    with contextlib.suppress(OSError):  # not allowed everywhere, and only a precaution
        Path('/proc/self/oom_score_adj').write_bytes(FIRST_TO_GO)


def serve(answer: Callable[[bytes], bytes]) -> None:
    """Answer questions until the other end is closed, then stop any work in progress.

    :param answer: raises nothing; what it prints goes to stderr
    """
    out = os.dup(sys.stdout.fileno())
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    questions: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(questions,), daemon=True).start()
    while True:
        _write(out, framed(answer(questions.get())))


def _listen(questions: queue.SimpleQueue[bytes]) -> None:
    """Read questions; when they end, the process ends, even while it works on an answer."""
    with open(sys.stdin.fileno(), 'rb', closefd=False) as file:
        while len(length := file.read(_LENGTH.size)) == _LENGTH.size:
            questions.put(file.read(_LENGTH.unpack(length)[0]))
    os._exit(0)


def _write(out: int, message: bytes) -> None:
    left = memoryview(message)
    try:
        while left:
            left = left[os.write(out, left) :]
    except BrokenPipeError:
        os._exit(0)
