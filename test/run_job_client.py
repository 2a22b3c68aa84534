"""A client of run_job in a process of its own, to be killed.

python test/run_job_client.py ORDER SCRIPT QUANTITY
"""

from __future__ import annotations

import signal
import sys

from action_caller import ActionCaller
from bt_orchestrator_interfaces.action import RunJob
from bt_orchestrator_interfaces.msg import WorkOrder

READY = 'accepted: '


def main() -> None:
    """Wait for the end of the job, or to be killed, or for longer than any test takes."""
    signal.alarm(600)
    order, script, quantity = sys.argv[1:]
    caller = ActionCaller()
    wanted = WorkOrder(order=order, script=script, quantity=int(quantity))
    goal = RunJob.Goal(order=wanted, who='robot', reason='test')
    handle = caller.start('/bt_orchestrator/run_job', RunJob, goal)
    print(f'{READY}{order}')  # noqa: T201 - for the parent process
    caller.result(handle)


if __name__ == '__main__':
    main()
