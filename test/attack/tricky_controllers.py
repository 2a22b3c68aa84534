"""Simulated controllers whose results hurt, as long as a file says so.

    python test/attack/tricky_controllers.py FILE sim-cell --cell CELL --only gauge,probe ...

While FILE is there, every field of a result but `task_result` gets a value that hurts; now and
then a text of 1 MB.
"""

from __future__ import annotations

import random
import sys
from pathlib import Path
from typing import Any

from attack.garbage import LONG, fields

from bt_orchestrator.cli.main import main
from bt_orchestrator.model.action_type import TASK_RESULT, ActionType
from bt_orchestrator.model.cell import Component
from bt_orchestrator.model.goal import GoalEnd, GoalStatus
from bt_orchestrator.sim.controller import Controller
from bt_orchestrator.sim.results import simulated_result

NASTY = 'nasty'
"""The name of that file."""

_LONG_EVERY = 3


def make_tricky(flag: Path, drawn: random.Random) -> None:
    """Let the controllers of this process answer what hurts while a file is there."""
    count = 0

    def result(component: Component, action_type: ActionType, task: str) -> dict[str, Any]:
        nonlocal count
        plain = simulated_result(component, action_type, task)
        if not flag.exists():
            return plain
        count += 1
        hurting = fields(drawn, action_type.result)
        if 'message' in hurting and not count % _LONG_EVERY:
            hurting['message'] = drawn.choice('a☃"\\') * LONG
        return {**plain, **hurting, **({TASK_RESULT: True} if TASK_RESULT in plain else {})}

    def success(controller: Controller[Any], task: str, _: int) -> GoalEnd:
        # Made anew for every goal: a controller itself makes it once a task.
        fields_now = result(controller._component, controller._type, task)
        return GoalEnd(GoalStatus.SUCCEEDED, fields_now)

    Controller._success = success  # type: ignore[method-assign, assignment]


if __name__ == '__main__':
    _flag, *_words = sys.argv[1:]
    make_tricky(Path(_flag), random.Random(_flag))
    sys.exit(main(_words))
