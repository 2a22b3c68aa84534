"""Measures a node from outside, in a process of its own, until it is killed.

    python test/attack/foreign_clock.py FOLDER JOURNAL

Asks the tree node and the plain node beside it for a parameter, 20 times a second each. To
FOLDER/pings.jsonl it appends how long each answer took, and every second that there is none. To
FOLDER/samples.jsonl it appends the memory of the process in FOLDER/node.pid and the size of its
journal. While node.pid is empty, the tree node is started again, and is not asked. All times are
of the machine's monotonic clock.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

from action_caller import ActionCaller
from attack.plain_node import NAME
from process_use import memory_mb
from rcl_interfaces.srv import GetParameters

PINGS, SAMPLES, PID = 'pings.jsonl', 'samples.jsonl', 'node.pid'

EVERY_S = 0.05
_AGAIN_S = 1.0
"""A service keeps ten requests: the first question tells all of a stall of up to 10 s."""

_SAMPLE_EVERY_S = 0.2


class Pinged:
    """One node that is asked, one question after the other."""

    def __init__(self, ros: ActionCaller, who: str, node: str, file: Path) -> None:
        self._client: Any = ros.node.create_client(GetParameters, f'{node}/get_parameters')
        self._who = who
        self._file = file
        self._open: dict[Any, float] = {}
        self._since: float | None = None
        """When the oldest question was asked that nothing has answered."""
        self._next = 0.0

    def look(self, now: float) -> None:
        """Ask, if it is time."""
        if now < self._next or not self._client.service_is_ready():
            return
        answer = self._client.call_async(GetParameters.Request(names=['use_sim_time']))
        if self._since is None:
            self._since = now
        else:
            self._write(now, None)
        self._open[answer] = now
        self._next = now + _AGAIN_S
        answer.add_done_callback(self._heard)

    def forget(self) -> None:
        """Expect no answer any more: another process is there."""
        given_up, self._open = list(self._open), {}
        for answer in given_up:
            answer.cancel()
        self._since, self._next = None, 0.0

    def _heard(self, answer: Any) -> None:
        asked = self._open.pop(answer, None)
        if asked is None:
            return
        now = time.monotonic()
        self._since = asked if self._since is None else self._since
        self._write(now, now - asked)
        self._since, self._next = None, max(asked + EVERY_S, now)

    def _write(self, now: float, took: float | None) -> None:
        """Note an answer, or that there is none yet."""
        assert self._since is not None
        note = {'who': self._who, 'at': now, 'took': took, 'silent': now - self._since}
        with self._file.open('a') as file:
            file.write(json.dumps(note) + '\n')


def main(folder: Path, journal: Path) -> None:
    """Ask and look for ever."""
    ros = ActionCaller()
    pings = folder / PINGS
    nodes = [
        Pinged(ros, 'node', '/bt_orchestrator', pings),
        Pinged(ros, 'plain', f'/{NAME}', pings),
    ]
    pid, sampled = '', 0.0
    print('clock ready: pings', flush=True)  # noqa: T201 - for the parent process
    while True:
        now = time.monotonic()
        if now - sampled > _SAMPLE_EVERY_S:
            before, pid, sampled = pid, (folder / PID).read_text(), now
            if pid != before:
                nodes[0].forget()
            if pid:
                _sample(folder / SAMPLES, now, int(pid), journal)
        for node in nodes if pid else nodes[1:]:
            node.look(now)
        ros.spin_for(EVERY_S / 10)


def _sample(file: Path, now: float, pid: int, journal: Path) -> None:
    parts = journal.parent.glob(f'{journal.name}*')
    try:
        sample = {
            'at': now,
            'mb': memory_mb(pid),
            'bytes': sum(part.stat().st_size for part in parts),
        }
    except OSError:
        return  # the process, or a part of the journal, has just gone
    with file.open('a') as lines:
        lines.write(json.dumps(sample) + '\n')


if __name__ == '__main__':
    main(Path(sys.argv[1]), Path(sys.argv[2]))
