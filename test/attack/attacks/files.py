"""Attacks at the journal's file, by others on the same computer."""

from __future__ import annotations

import resource
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

from attack.attacks.attack import Attack, Bounds
from attack.peer import Peer
from bt_orchestrator_interfaces.msg import Status
from chaos.readers import COPYING
from program_process import ProgramProcess

from bt_orchestrator.ros.qos import LATCHED


class Copies(Attack):
    """The journal copied and read all the time, by `sqlite3` and by verbs."""

    name = 'copies'
    in_short = False  # chaos does it all the time

    _VERBS = (
        ('events', '--format', 'csv'),
        ('history', '--items', '--json'),
        ('events', '--format', 'xes'),
    )

    def run(self, peer: Peer) -> None:
        """Copy until the end, one verb after the other."""
        folder = peer.folder / 'copies'
        folder.mkdir(exist_ok=True)
        words = [peer.target.journal, str(peer.target.pid), str(folder)]
        copying = ProgramProcess(words, folder, 'copying', [str(COPYING)])
        try:
            while peer.goes_on():
                for number, (verb, *options) in enumerate(self._VERBS):
                    self._read(peer, folder, f'{verb}_{number}', [verb, *options])
        finally:
            copying.kill()

    def _read(self, peer: Peer, folder: Path, name: str, words: list[str]) -> None:
        verb, *options = words
        given = [verb, '--journal', peer.target.journal, *options]
        status = ProgramProcess(given, folder, name).wait()
        peer.count('readings')
        if status:
            peer.complain(f'{" ".join(words)} ended with {status}')


class Lock(Attack):
    """The journal locked by another process, a second at a time."""

    name = 'lock'

    _LOCKED_S = 1.0
    _FREE_S = 0.5

    def run(self, peer: Peer) -> None:
        """Lock it again and again, in every way that SQLite has."""
        with closing(sqlite3.connect(peer.target.journal, isolation_level=None)) as journal:
            while peer.goes_on():
                for word in ('IMMEDIATE', 'EXCLUSIVE'):
                    try:
                        journal.execute(f'BEGIN {word}')
                    except sqlite3.OperationalError:
                        peer.count('refused locks')
                    else:
                        peer.count('locks')
                        peer.wait(self._LOCKED_S)
                        journal.execute('ROLLBACK')
                    peer.wait(self._FREE_S)


class Disk(Attack):
    """A disk on which nothing more can be written."""

    name = 'disk'
    bounds = Bounds(breaks_journal=True)

    _TOLD_S = 60.0

    def run(self, peer: Peer) -> None:
        """Limit what the node may write, see that it says so, and lift the limit again."""
        failures: list[str] = []

        def hear(status: Any) -> None:
            if status.journal_failure:
                failures.append(status.journal_failure)

        topic = f'{peer.target.node}/status'
        peer.ros.node.create_subscription(Status, topic, hear, LATCHED)
        before = resource.prlimit(peer.target.pid, resource.RLIMIT_FSIZE)
        resource.prlimit(peer.target.pid, resource.RLIMIT_FSIZE, (4096, before[1]))
        if not peer.wait(self._TOLD_S, lambda: failures):
            peer.complain('the disk is full, and no status says so')
        peer.wait(peer.left_s)
        resource.prlimit(peer.target.pid, resource.RLIMIT_FSIZE, before)
