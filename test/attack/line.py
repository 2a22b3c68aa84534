"""The line that is attacked: that of chaos, with two controllers more that nobody should trust."""

from __future__ import annotations

import random

from chaos.line import REMEMBERED_S
from chaos.line import cell as chaos_cell

UNTRUSTED = ('gauge', 'probe')
"""Their results are what an attack wants (`tricky_controllers.py`): numbers, and texts."""

STATE_TOPIC = '/probe/state'
"""Whether the probe is ready; it repeats it every second."""

ITEMS = 3
"""Of each order."""


def cell(drawn: random.Random) -> str:
    """Return the cell file."""
    return f"""{chaos_cell(drawn, ITEMS).rstrip()}
  gauge: {{section: 2, action: gauge/task, type: bt_orchestrator_interfaces/action/Component,
          result_timeout: {REMEMBERED_S}}}
  probe: {{section: 2, action: probe/task, type: bt_orchestrator_interfaces/action/RunJob,
          result_timeout: {REMEMBERED_S},
          state: {{topic: probe/state, type: std_msgs/msg/String, field: data, ready: [READY]}}}}
"""


SCRIPT = """
script: attacked
sections:
  1:
    - {id: feed, task: TASK_A, action: feeder/task, qty_change: 1}
  2:
    - parallel:
      - {id: look, task: TASK_A, action: camera/task}
      - {id: work, task: TASK_A, action: worker/task}
      - {id: gauge, task: TASK_A, action: gauge/task}
      - {id: probe, task: PROBE, action: probe/task}
  3:
    - id: pack
      task: TASK_A
      action: packer/task
      qty_change: -1
      args:
        special_argument_1: "${results.probe.message}"
        special_argument_2: "${results.gauge.measurement}"
lateral_dependencies:
  - {flag: seen, upstream: look, downstream: pack, capacity: 2}
"""
"""What the untrusted controllers answer goes to another one."""
