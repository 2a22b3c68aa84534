"""The garbage collector of a node looks rarely, and still frees what nothing else can."""

from __future__ import annotations

import json
import subprocess
import sys
from typing import NamedTuple

_PROGRAM = """
import gc, json
from bt_orchestrator.ros import memory

class Knot:
    def __init__(self):
        self.itself = self

{first}
looks = []
gc.callbacks.append(lambda phase, found: looks.append(phase) if phase == 'stop' else None)
there = gc.get_freeze_count()
kept = [[] for _ in range(10_000)]
during_work = len(looks)
for _ in range(200_000):
    Knot()
left = sum(isinstance(one, Knot) for one in gc.get_objects())
print(json.dumps([there, during_work, left]))
"""


class Seen(NamedTuple):
    """What a program saw of the collector."""

    out_of_looks: int
    looks: int
    left: int


def seen(first: str) -> Seen:
    """Run the program, which does something first."""
    words = [sys.executable, '-c', _PROGRAM.format(first=first)]
    done = subprocess.run(words, stdout=subprocess.PIPE, text=True, check=True)
    return Seen(*json.loads(done.stdout))


def test_what_stays_costs_no_looks_and_garbage_goes() -> None:
    by_itself = seen('pass')
    assert by_itself.looks > 10  # or else there is nothing to be done
    rarely = seen('memory.collect_rarely()')
    assert rarely.out_of_looks > 5_000
    assert rarely.looks <= 1
    assert rarely.left <= 2 * 20_000
