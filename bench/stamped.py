"""The program, or the chain, which notes how long each turn takes from its wait to its first goal.

`run …` is the program; EXECUTOR CYCLES is the chain. At its end it writes the times in seconds as
JSON.
"""

from __future__ import annotations

import atexit
import json
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rclpy.action.client import ActionClient

from bench import chain
from bt_orchestrator.cli.main import main
from bt_orchestrator.ros.actions.goal_client import GoalClient
from bt_orchestrator.ros.executor.lean_waits import WaitList

FILE = 'BENCH_STAMPS'
"""Environment variable: where to write them."""


class Stamps:
    """The times of the turns that sent a goal."""

    def __init__(self) -> None:
        self.taken_s: list[float] = []
        self._woken_s: float | None = None

    def woken(self) -> None:
        """Note when a wait found something."""
        self._woken_s = time.monotonic()

    def sent(self, send: Callable[..., Any]) -> Callable[..., Any]:
        """Return a way to send that notes how long ago the wait ended, once a turn."""

        def stamped(*args: Any) -> Any:
            question = send(*args)
            if self._woken_s is not None:
                self.taken_s.append(time.monotonic() - self._woken_s)
                self._woken_s = None
            return question

        return stamped


def stamp(stamps: Stamps) -> None:
    """Note the times from now on."""
    client: Any = GoalClient
    client.send = stamps.sent(client.send)
    plain: Any = ActionClient
    plain.send_goal_async = stamps.sent(plain.send_goal_async)
    after_each_wait(stamps.woken)


def after_each_wait(call: Callable[[], None]) -> None:
    """Call something whenever a wait of our executor has found something."""
    waits: Any = WaitList
    wait = waits.wait

    def noted(*args: Any) -> Any:
        ready = wait(*args)
        if ready:
            call()
        return ready

    waits.wait = noted


if __name__ == '__main__':
    _stamps = Stamps()
    stamp(_stamps)
    atexit.register(lambda: Path(os.environ[FILE]).write_text(json.dumps(_stamps.taken_s)))
    if sys.argv[1] == 'run':
        sys.exit(main())
    chain.main()
