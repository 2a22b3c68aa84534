"""The program, started from a process that has loaded it: that is half the work of a short test.

This file is two things. Tests import it, and ask for processes. Run by Python it is the process
that has everything loaded, and is forked for each of them. From its fork on, a process is like any
other: it has a command line, an environment, a folder and a session of its own. The processes of a
node, for forecasts and orders, are forks too.
"""

from __future__ import annotations

import ctypes
import gc
import json
import os
import re
import runpy
import select
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any, BinaryIO

PRELOADED = (
    *('bt_orchestrator.cli.main', 'bt_orchestrator.cli.run', 'bt_orchestrator.cli.bootstrap'),
    *('bt_orchestrator.cli.sim_cell', 'bt_orchestrator.cli.status', 'bt_orchestrator.ros.node'),
    *('bt_orchestrator.ros.executor.lean_executor', 'bt_orchestrator.store.sqlite.store'),
    'bt_orchestrator.sim.controllers.process',
    *('rclpy.action', 'rclpy.executors', 'std_msgs.msg'),
)
"""What most processes of a cell import. No extension: a cell without it loads nothing of it."""

TYPE_SUPPORTS = (
    *('action_msgs', 'bt_orchestrator_interfaces', 'builtin_interfaces', 'diagnostic_msgs'),
    *('rcl_interfaces', 'service_msgs', 'std_msgs', 'type_description_interfaces'),
    'unique_identifier_msgs',
)
"""Packages whose messages they send."""

CHILDREN_BY_PYTHON = 'CHILDREN_BY_PYTHON'
"""Environment variable: Python starts the processes of a node, as it does without this file."""


class Forks:
    """Asks a process that has everything loaded for forks of it. Ends it in `close`."""

    def __init__(self, to_it: socket.socket) -> None:
        self._socket = to_it
        self._answers = to_it.makefile('r')
        self._lock = threading.Lock()

    def start(
        self,
        words: Sequence[str],
        files: Sequence[int],
        cwd: Path,
        environment: Mapping[str, str],
    ) -> int:
        """Start a process; return its pid.

        :param files: its standard input, output and errors
        """
        asked = {'words': [*words], 'cwd': str(cwd), 'environment': {**environment}}
        return self._ask(asked, files)

    def exit_status(self, pid: int) -> int:
        """Return the exit status of a process that has ended, once."""
        return self._ask({'ended': pid})

    def close(self) -> None:
        """End; the processes that were started go on."""
        self._socket.close()
        self._answers.close()

    def _ask(self, asked: Mapping[str, Any], files: Sequence[int] = ()) -> int:
        with self._lock:
            socket.send_fds(self._socket, [json.dumps(asked).encode() + b'\n'], files)
            return int(self._answers.readline())


class LoadedProgram:
    """Starts processes of the program. Ends in `close`, or with this process."""

    def __init__(self) -> None:
        """Start loading."""
        ours, theirs = socket.socketpair()
        words = [sys.executable, '-u', __file__, str(theirs.fileno())]
        with theirs:
            self._process = subprocess.Popen(
                words, pass_fds=[theirs.fileno()], start_new_session=True
            )
        self._forks = Forks(ours)

    def start(
        self,
        words: Sequence[str],
        output: BinaryIO,
        errors: BinaryIO,
        cwd: Path,
        environment: Mapping[str, str],
    ) -> LoadedProcess:
        """Start a process.

        :param words: a command line from the verb on
        """
        with Path(os.devnull).open('rb') as nothing:
            files = [file.fileno() for file in (nothing, output, errors)]
            return LoadedProcess(self._forks, self._forks.start(words, files, cwd, environment))

    def close(self) -> None:
        """End; the processes that were started go on."""
        self._forks.close()
        self._process.wait()


class LoadedProcess:
    """One process of the program: what tests need of `subprocess.Popen`."""

    def __init__(self, forks: Forks, pid: int) -> None:
        self.pid = pid
        self._forks = forks
        self._handle = os.pidfd_open(pid)
        self._status: int | None = None

    def __del__(self) -> None:
        os.close(self._handle)

    def poll(self) -> int | None:
        """Return its exit status; None: it has not ended."""
        return self._ended_within(0.0)

    def wait(self, timeout: float | None = None) -> int:
        """Return its exit status, once it has ended.

        :raises subprocess.TimeoutExpired: it has not ended in so many seconds
        """
        status = self._ended_within(timeout)
        if status is None:
            raise subprocess.TimeoutExpired(f'process {self.pid}', timeout or 0.0)
        return status

    def send_signal(self, number: int) -> None:
        """Send it a signal, unless it has ended."""
        if self.poll() is None:
            signal.pidfd_send_signal(self._handle, number)

    def kill(self) -> None:
        """End it without a word."""
        self.send_signal(signal.SIGKILL)

    def _ended_within(self, seconds: float | None) -> int | None:
        if self._status is None and select.select([self._handle], [], [], seconds)[0]:
            self._status = self._forks.exit_status(self.pid)
        return self._status


class LoadedChild(LoadedProcess):
    """A process of a node: what `base.child_process` needs of `subprocess.Popen`."""

    def __init__(self, forks: Forks, module: str) -> None:
        theirs, write = os.pipe()
        read, also_theirs = os.pipe()
        files = [theirs, also_theirs, sys.stderr.fileno()]
        super().__init__(forks, forks.start([module], files, Path.cwd(), os.environ))
        os.close(theirs)
        os.close(also_theirs)
        self.stdin = os.fdopen(write, 'wb', buffering=0)
        self.stdout = os.fdopen(read, 'rb', buffering=0)

    @property
    def returncode(self) -> int | None:
        """Its exit status, once it was waited for; None: it was not."""
        return self._status


def _fork_children() -> None:
    """Let this process fork its children from another one, which has no ROS and no threads."""
    ours, theirs = socket.socketpair()
    if _fork() == 0:
        ours.close()
        os.setsid()
        _serve(theirs)
        import_module(sys.argv[1]).main()
        sys.exit()
    theirs.close()
    forks = Forks(ours)

    def popen(words: Sequence[str], **_: Any) -> LoadedChild:
        return LoadedChild(forks, words[-1])

    its = vars(import_module('bt_orchestrator.base.child_process'))
    its['subprocess'] = SimpleNamespace(**{**vars(subprocess), 'Popen': popen})


def _serve(requests: socket.socket) -> None:
    """Fork at each request. Returns in the fork; here, it ends with who asks."""
    while True:
        line, files, _, _ = socket.recv_fds(requests, 1 << 20, 3)
        while line and not line.endswith(b'\n'):
            line += requests.recv(1 << 20)
        if not line:
            os._exit(0)
        asked = json.loads(line)
        if 'ended' in asked:
            answer = os.waitstatus_to_exitcode(os.waitpid(asked['ended'], 0)[1])
        elif (answer := _fork()) == 0:
            requests.close()
            _become(asked, files)
            return
        for file in files:
            os.close(file)
        requests.sendall(b'%d\n' % answer)


def _fork() -> int:
    """Fork, and start the threads of LTTng in the fork, which ends them; rclpy has loaded it."""
    maps = Path('/proc/self/maps').read_text(encoding='utf-8')
    paths = set(re.findall(r'/\S+/liblttng-ust[-.](?!tracepoint|common)\S+', maps))
    libraries = [ctypes.CDLL(path) for path in paths]
    before = (ctypes.c_byte * 128)()  # a sigset_t
    for library in libraries:
        _of_lttng(library, 'before_fork')(before)
    pid = os.fork()
    for library in reversed(libraries):
        _of_lttng(library, 'after_fork_parent' if pid else 'after_fork_child')(before)
    return pid


def _of_lttng(library: ctypes.CDLL, name: str) -> Any:
    """Return a function of LTTng; from version 2.13 on their names begin with its own."""
    return getattr(library, f'lttng_ust_{name}', None) or getattr(library, f'ust_{name}')


def _become(asked: Mapping[str, Any], files: Sequence[int]) -> None:
    """Become a process with its own arguments, environment, folder, files and session."""
    os.setsid()
    os.chdir(asked['cwd'])
    for number, file in enumerate(files):
        os.dup2(file, number)
        os.close(file)
    os.environ.clear()
    os.environ.update(asked['environment'])
    paths = os.environ.get('PYTHONPATH', '').split(os.pathsep)
    sys.path[:0] = [path for path in paths if path not in ('', *sys.path)]
    sys.argv[1:] = asked['words']


if __name__ == '__main__':
    sys.path.pop(0)  # the folder of the tests
    for _name in PRELOADED:
        import_module(_name)
    for _name in TYPE_SUPPORTS:
        import_module('rosidl_generator_py').import_type_support(_name)
    gc.freeze()  # no fork looks for garbage among these objects, at its end least of all
    _serve(socket.socket(fileno=int(sys.argv[1])))
    if sys.argv[1] == 'run' and CHILDREN_BY_PYTHON not in os.environ:
        _fork_children()
    runpy.run_module('bt_orchestrator', run_name='__main__', alter_sys=True)
