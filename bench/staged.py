"""The program, which notes how long each stage of a turn that sends goals has taken.

At its end it writes the stages of each turn in seconds as JSON, one list for the turns of one goal
and one for those of several, with which cycles begin.
"""

from __future__ import annotations

import atexit
import json
import os
import sys
import time
from collections.abc import Callable
from functools import wraps
from itertools import pairwise
from pathlib import Path
from typing import Any

from bench.stamped import FILE, after_each_wait
from bt_orchestrator.cli.main import main
from bt_orchestrator.engine.runtime.flights import Flights
from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.ros.actions.goal_client import GoalClient
from bt_orchestrator.store.sqlite import store

WOKEN, SENT = 'the wait ends', 'the goal is sent'

ENDS = {
    'the result is taken and converted': (Orchestrator, 'settle', 'begin'),
    'land': (Flights, 'land', 'end'),
    'ticks until nothing changes': (Orchestrator, '_tick_until_still', 'end'),
    "hand-over to the journal's thread": (store.SqliteStore, 'append', 'begin'),
    'looks at files, text of the events': (store, '_row', 'end'),
    'SQLite and the disk': (store, '_add', 'end'),
    'looks at files, the mark': (store.SqliteStore, 'append', 'end'),
    'back to the thread that ticks': (GoalClient, 'send', 'begin'),
    SENT: (GoalClient, 'send', 'end'),
}
"""What ends each stage, in their order: where it is, its name, and which moment of it.

Of what happens several times before the first goal is sent, the last counts.
"""


class Turn:
    """The stages of the turn that goes on."""

    def __init__(self) -> None:
        self.of_one: list[dict[str, float]] = []
        self.of_several: list[dict[str, float]] = []
        self._ended_s: dict[str, float] = {}
        self._sent = 0

    def end(self, stage: str) -> None:
        """Note that a stage has ended."""
        if not self._sent:
            self._ended_s[stage] = time.monotonic()
        self._sent += stage == SENT

    def begin(self) -> None:
        """Keep the stages of the turn before, if it sent a goal through all of them."""
        if self._sent and self._ended_s.keys() == {WOKEN, *ENDS}:
            lasts = pairwise(self._ended_s[stage] for stage in (WOKEN, *ENDS))
            turns = self.of_one if self._sent == 1 else self.of_several
            turns.append({s: end - begin for s, (begin, end) in zip(ENDS, lasts, strict=True)})
        self._ended_s, self._sent = {}, 0
        self.end(WOKEN)


def _note(turn: Turn, stage: str, of: Any, name: str, moment: str) -> None:
    function: Callable[..., Any] = getattr(of, name)

    @wraps(function)
    def noted(*args: Any, **kwargs: Any) -> Any:
        if moment == 'begin':
            turn.end(stage)
        value = function(*args, **kwargs)
        if moment == 'end':
            turn.end(stage)
        return value

    setattr(of, name, noted)


if __name__ == '__main__':
    _turn = Turn()
    for _stage, _place in ENDS.items():
        _note(_turn, _stage, *_place)
    after_each_wait(_turn.begin)
    atexit.register(
        lambda: Path(os.environ[FILE]).write_text(json.dumps([_turn.of_one, _turn.of_several]))
    )
    sys.exit(main())
