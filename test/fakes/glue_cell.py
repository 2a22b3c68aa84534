"""A small cell in which two robots can glue, and a product of it."""

CELL = """\
cell: glue_cell
conveyor:
  sections: 4
  action: /belt/index
  type: bt_orchestrator_interfaces/action/Conveyor
  task: MOVE_ONE_INDEX
  duration: 1.0
components:
  loader:
    section: 1
    action: /loader/task
    type: bt_orchestrator_interfaces/action/UnpackingArm
    durations: {PLACE_AT_CONVEYOR: 1.0}
    capabilities: {load: {task: PLACE_AT_CONVEYOR, qty_change: 1}}
  robot_a:
    section: 2
    action: /robot_a/task
    type: bt_orchestrator_interfaces/action/Component
    durations: {TASK_A: 2.0}
    capabilities: {glue: {task: TASK_A}}
  robot_b:
    section: 3
    action: /robot_b/task
    type: bt_orchestrator_interfaces/action/Component
    durations: {TASK_A: 4.0, TASK_B: 2.0}
    capabilities: {glue: {task: TASK_A}, close: {task: TASK_B}}
  packer:
    section: 4
    action: /packer/task
    type: bt_orchestrator_interfaces/action/PackingArm
    durations: {PICK_AND_PACK: 1.0}
    capabilities: {pack: {task: PICK_AND_PACK, qty_change: -1}}
"""
RECIPE = """\
recipe: BOX-7
version: 3
script: box
operations:
  - {id: load, do: load}
  - {id: glue, do: glue}
  - {id: close, do: close}
  - {id: pack, do: pack}
"""
