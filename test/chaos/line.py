"""The line that is shot at: three sections, goals that take random times."""

from __future__ import annotations

import random

SPEED = 10.0

COMPONENTS = {'feeder': 1, 'camera': 2, 'worker': 2, 'packer': 3}
"""Their sections. Each does TASK_A; none of its tasks may be repeated."""

_MOST_LATE_S = 6.0

REMEMBERED_S = 5.0
"""Seconds for which its controllers remember a goal that ended: short, so that a restart can be
later than that."""

LONG_REMEMBERED_S = 60.0
"""The same where a node may be away for longer, because its database is."""


def cell(drawn: random.Random, items: int, remembered_s: float = REMEMBERED_S) -> str:
    """Return a cell file in which each goal takes between 0.1 and 0.7 s of real time."""
    components = '\n'.join(
        f'  {name}: {{section: {section}, action: {name}/task, type: {_TYPE}/Component, '
        f'result_timeout: {remembered_s}, faults: [{_delays(drawn, "TASK_A", items)}]}}'
        for name, section in COMPONENTS.items()
    )
    return f"""
cell: chaos_cell
conveyor:
  sections: 3
  action: conveyor/index
  type: {_TYPE}/Conveyor
  task: MOVE_ONE_INDEX
  result_timeout: {remembered_s}
components:
{components}
"""


_TYPE = 'bt_orchestrator_interfaces/action'


def _delays(drawn: random.Random, task: str, goals: int) -> str:
    return ', '.join(
        f'"{task}#{n}=late:{drawn.uniform(0.0, _MOST_LATE_S):.2f}"' for n in range(1, goals + 1)
    )


SCRIPT = """
script: small
sections:
  1:
    - {id: feed, task: TASK_A, action: feeder/task, qty_change: 1}
  2:
    - parallel:
      - {id: look, task: TASK_A, action: camera/task}
      - {id: work, task: TASK_A, action: worker/task}
  3:
    - {id: pack, task: TASK_A, action: packer/task, qty_change: -1}
lateral_dependencies:
  - {flag: seen, upstream: look, downstream: pack, capacity: 2}
"""
