"""The contents of a demo's folder: a demo that was killed goes on from them."""

from __future__ import annotations

import fcntl
import json
import os
import select
import signal
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import IO

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.cli.programs import FAREWELL_S
from bt_orchestrator.script.users.file import own_folder


class DemoUnusable(OrchestratorError):
    """The folder of the demo cannot be used as it was asked for."""


@dataclass(frozen=True)
class DemoRecord:
    """The facts with which a demo goes on."""

    domain: str
    """ROS_DOMAIN_ID of everything in it."""
    cell: str
    order: str
    """Path of the work order."""
    speed: float = 4.0
    faults: Sequence[str] = ()
    trees: Sequence[str] = ()
    executor: str = 'single'
    page: int | None = None
    """Port of the operator page; None: there is none."""
    shifts: str = ''
    """File of shifts for the page; empty: it shows no account."""
    opcua: int | None = None
    """Port of the OPC UA server; None: there is none."""
    processes: Mapping[str, int] = field(default_factory=dict)
    """Process ids by name."""

    @property
    def stays(self) -> bool:
        """Tell whether it goes on after the order: somebody may look at it."""
        return self.page is not None or self.opcua is not None


def default_folder() -> Path:
    """Return where a demo keeps its things unless told otherwise."""
    return own_folder(os.environ, 'XDG_STATE_HOME', '.local/state') / 'demo'


class DemoFolder:
    """One demo's journal, logs and record. A context, in which no other demo may use it."""

    def __init__(self, path: Path) -> None:
        """Take the folder.

        :raises DemoUnusable: it cannot be written, or another demo runs in it
        """
        self.path = path
        self.journal = path / 'journal.sqlite3'
        self._record = path / 'demo.json'
        self._lock = _locked(path)

    def __enter__(self) -> DemoFolder:
        return self

    def __exit__(self, *exception: object) -> None:
        self._lock.close()

    def begin(self) -> None:
        """Forget the demo before, and end what a killed one has left running."""
        left = self._read()
        for pid in left.processes.values() if left else ():
            stop_process(pid)
        self.forget()
        for path in self.path.glob(f'{self.journal.name}*'):
            path.unlink()

    def left(self) -> DemoRecord:
        """Return the record of a demo that did not come to its end.

        :raises DemoUnusable: there is none
        """
        record = self._read()
        if record is None:
            raise DemoUnusable(
                f'there is no demo to resume: the last one in {self.path} came to its end, or '
                'there was none; start one without --resume'
            )
        return record

    def keep(self, record: DemoRecord) -> None:
        """Write the record, in one piece."""
        new = self._record.with_suffix('.new')
        new.write_text(json.dumps(asdict(record)))
        new.replace(self._record)

    def forget(self) -> None:
        """Note that nothing is left to go on with."""
        self._record.unlink(missing_ok=True)

    def _read(self) -> DemoRecord | None:
        try:
            return DemoRecord(**json.loads(self._record.read_text()))
        except (OSError, TypeError, ValueError):
            return None


def is_ours(pid: int) -> bool:
    """Tell whether a process runs that is one of a demo's, and not another with its number."""
    try:
        words = Path(f'/proc/{pid}/cmdline').read_bytes().split(b'\0')
    except OSError:
        return False
    return b'bt_orchestrator' in words


def stop_process(pid: int) -> None:
    """Ask a process of an earlier demo to end, and kill it if it does not."""
    if not is_ours(pid):
        return
    handle = os.pidfd_open(pid)
    try:
        os.kill(pid, signal.SIGINT)
        if not select.select([handle], [], [], FAREWELL_S)[0]:
            os.kill(pid, signal.SIGKILL)
            select.select([handle], [], [], FAREWELL_S)
    except ProcessLookupError:
        pass  # it has ended meanwhile
    finally:
        os.close(handle)


def _locked(path: Path) -> IO[str]:
    try:
        path.mkdir(parents=True, exist_ok=True)
        lock = (path / 'demo.lock').open('a')
    except OSError as error:
        what = f'the folder {path} cannot be used: {error.strerror}'
        raise DemoUnusable(f'{what}; name another --folder') from error
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        lock.close()
        raise DemoUnusable(
            f'another demo runs in {path}; wait for its end, or name another --folder'
        ) from None
    return lock
