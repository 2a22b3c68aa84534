"""The state of the cell: plain data, changed by `model.fold` alone and read by everyone."""

from bt_orchestrator.model.state.cell_state import DERIVED, CellState, Hold
from bt_orchestrator.model.state.job_state import ItemState, JobState, Progress
from bt_orchestrator.model.state.line import (
    Cycle,
    End,
    Finished,
    FlagState,
    KnownSetup,
    ManualRun,
    OutOfService,
    PassedTask,
    Phase,
    Reading,
    Reject,
    RejectCount,
    SectionState,
    TaskState,
    same_args,
    same_task,
)

__all__ = [
    'Phase',
    'End',
    'TaskState',
    'PassedTask',
    'same_task',
    'same_args',
    'ItemState',
    'Progress',
    'JobState',
    'Cycle',
    'Finished',
    'SectionState',
    'FlagState',
    'Reading',
    'Reject',
    'RejectCount',
    'ManualRun',
    'OutOfService',
    'KnownSetup',
    'Hold',
    'DERIVED',
    'CellState',
]
