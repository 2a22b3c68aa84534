"""A process that does what its questions say, for tests of `child_process`."""

from __future__ import annotations

import os
import signal
import sys

from bt_orchestrator.base.child_process import ChildProcess, be_modest, serve


def answer(question: bytes) -> bytes:
    """Return the question; some words are carried out."""
    if question == b'die':
        os.kill(os.getpid(), signal.SIGKILL)
    while question == b'compute':  # not even a signal handler of Python's own would come between
        sum(range(10_000))
    if question == b'print':
        sys.stdout.write('this is no answer\n')
        sys.stdout.flush()
    return b'%d' % os.nice(0) if question == b'nice' else question


def ask_and_wait() -> None:
    """Let a process work for this one, and say which."""
    child = ChildProcess('fakes.asked_child', b'')
    child.ready()
    sys.stdout.write(f'{child.pid}\n')
    sys.stdout.flush()
    child.ask(b'compute')


if __name__ == '__main__':
    be_modest(3)
    serve(answer)
