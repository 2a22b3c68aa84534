"""What the state topic of the small cell's worker says, as a test wants it and for as long."""

from __future__ import annotations

from cell_processes import CellProcesses
from std_msgs.msg import String

from bt_orchestrator.ros.qos import LATCHED

SAYS_NOTHING = 'worker.=silent'
"""Fault of the simulated worker, so that the test alone says how it is."""


class WorkerState:
    """The publisher; a fault that ends by itself may be over before a busy machine begins."""

    def __init__(self, cell: CellProcesses) -> None:
        """Say that the worker is not ready.

        :param cell: made with the fault `SAYS_NOTHING`
        """
        self._publisher = cell.watch.ros.node.create_publisher(String, '/worker/state', LATCHED)
        self._publisher.publish(String(data='NOT_READY'))

    def be_ready(self) -> None:
        """Say that the worker is ready now."""
        self._publisher.publish(String(data='READY'))
