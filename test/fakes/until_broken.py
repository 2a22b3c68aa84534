"""Run jobs in a journal with little room on its disk, until nothing can be written any more.

    python until_broken.py JOURNAL LARGEST_FILE_BYTES

The limit is the kernel's: a write beyond it fails, as on a full disk. Prints what the orchestrator
says, the number of its last event, and the answer to a command.
"""

from __future__ import annotations

import itertools
import json
import resource
import sys
from pathlib import Path

from fakes.commands import Pause
from fakes.line import THREE, Line
from fakes.long_journal import LongRun
from fakes.operator import ann

from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job


def main(path: Path, largest: int) -> None:
    """Run until broken."""
    run = LongRun(path, Line(), synchronous='FULL')
    resource.setrlimit(resource.RLIMIT_FSIZE, (largest, largest))
    orchestrator = run.orchestrator
    for number in itertools.count(1):
        answer = orchestrator.ask(AddJobs((Job(f'J{number}', run.line.script(THREE), 3),)))
        while not orchestrator.broken and orchestrator.state.jobs and run.clock.advance():
            orchestrator.settle()
        if orchestrator.broken:
            break
    refused = orchestrator.ask(Pause(ann()))
    report = {
        'broken': orchestrator.broken,
        'seq': orchestrator.state.seq,
        'accepted': answer.accepted,
        'pause': refused.accepted,
        'live': list(orchestrator.state.jobs),
    }
    print(json.dumps(report))  # noqa: T201 - for the test that started this
    run.kill()


if __name__ == '__main__':
    main(Path(sys.argv[1]), int(sys.argv[2]))
