"""Attacks at the process of the node and at its computer's clock."""

from __future__ import annotations

import os
import signal

from attack.attacks.attack import Attack, Bounds
from attack.peer import Peer
from attack.steppable_node import AHEAD

_STOPPED_S = 3.0


class Stopped(Attack):
    """The node stopped for seconds, and continued."""

    name = 'stopped'
    bounds = Bounds(stalls_s=_STOPPED_S)

    def run(self, peer: Peer) -> None:
        """Stop it for as long as it may be, with pauses as long.

        The plain node is stopped with it: what was sent to either meanwhile, DDS may repeat late.
        """
        while True:
            for with_signal, then_s in ((signal.SIGSTOP, _STOPPED_S), (signal.SIGCONT, 0.0)):
                for pid in (peer.target.pid, peer.target.plain_pid):
                    os.kill(pid, with_signal)
                peer.wait(then_s)
            peer.count('stops')
            if peer.left_s < _STOPPED_S:
                return
            peer.wait(_STOPPED_S)


class Clock(Attack):
    """The wall clock of the node's computer set back and forth."""

    name = 'clock'

    _STEPS_S = (120.0, -3600.0, 0.5, 86_400.0 * 400, -1.0, 86_400.0 * -400, 60.0)
    _EVERY_S = 0.7

    def run(self, peer: Peer) -> None:
        """Set it, and at the end to what it is."""
        steps = list(self._STEPS_S)
        peer.drawn.shuffle(steps)
        try:
            for ahead_s in steps:
                self._set(peer, ahead_s)
                peer.wait(max(self._EVERY_S, peer.seconds / len(steps)))
        finally:
            self._set(peer, 0.0)

    def _set(self, peer: Peer, ahead_s: float) -> None:
        (peer.folder / AHEAD).write_text(str(ahead_s))
        os.kill(peer.target.pid, signal.SIGUSR1)
        peer.count('steps')
