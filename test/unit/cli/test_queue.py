"""The verb `queue`: what it prints, and wrong use, which needs no node."""

from __future__ import annotations

import shlex
from datetime import datetime

import pytest
from fakes import statuses

from bt_orchestrator.cli.main import main
from bt_orchestrator.cli.queue import lines
from bt_orchestrator.model.jobs.isa95 import JobWord

DUE = 1779084000.0


@pytest.mark.parametrize(
    ('line', 'message'),
    [
        ('job hold a', 'arguments are required: --reason'),
        ('job hold --reason w', 'arguments are required: JOB'),
        ('job requeue --as B --reason w', 'arguments are required: JOB'),
        ('queue list a', 'unrecognized arguments: a'),
        ('queue add', 'arguments are required: ORDER'),
        ('job move a --reason w', 'arguments are required: N'),
        ('job move a first --reason w', 'N: expected a whole number from 0 to 4294967295'),
        ('job update a --reason w', 'say what to change: --quantity, --param, --script'),
        ('job update a --reason w --param lot', "--param: expected NAME=VALUE, found 'lot'"),
        ('job update a --reason w --details \'{"a": NaN}\'', 'must have finite numbers'),
        ('job update a --reason w --details \'{"a"\'', '`details` must be JSON'),
        ('job update a --reason w --details /no/such/file', 'No such file'),
        ('job update a --reason w --details /dev/zero', 'this is a pipe or a device'),
        ('job update a --reason w --priority=32768', "from -32768 to 32767, found '32768'"),
        ('job update a --reason w --priority=1.5', "from -32768 to 32767, found '1.5'"),
        ('job update a --reason w --start=2026-05-18T06:00', 'write 2026-05-18T06:00Z for UTC'),
        ('job update a --reason w --due=2039-01-01T00:00Z', 'expected between 1970 and 2038'),
        ('queue hold a --at 3 --reason w', 'unrecognized arguments: --at 3'),
        ('job update a --held --reason w', 'unrecognized arguments: --held'),
        ('queue list --as B', 'unrecognized arguments: --as B'),
        ('queue add a --priority 0', 'unrecognized arguments: --priority 0'),
        ('queue stop-after lunch --reason w', "expected one of item, job, never; found 'lunch'"),
    ],
)
def test_wrong_use_is_told(line: str, message: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        raise SystemExit(main(shlex.split(line)))
    assert ended.value.code == 2
    assert message in capsys.readouterr().err


def test_running_jobs_stand_apart_from_the_queue() -> None:
    held, waiting = JobWord.NOT_ALLOWED_TO_START, JobWord.ALLOWED_TO_START
    status = statuses.status(
        stop_after='job',
        jobs=[
            statuses.job('A', packed=2, ending='stopping', expected_end_s=61.4),
            statuses.job('B', position=1, state=held, priority=7, due=DUE),
            statuses.job('C', position=2, state=waiting, expected_end_s=7265.0, recipe='P-1'),
            statuses.job('D', position=3, state=waiting, expected_end_s=5.2),
            statuses.job('E', state=JobWord.ENDED),
        ],
    )
    due = f'{datetime.fromtimestamp(DUE):%Y-%m-%d %H:%M}'
    assert list(lines(status)) == [
        'the cell stops after the current job',
        'on the line:',
        '     A (small, 10 items): Running/stopping, ends in about 1 min 01 s, 2 packed',
        'queue:',
        f'   1 B (small, 10 items): NotAllowedToStart, priority 7, due {due}',
        '   2 C (small from P-1, 10 items): AllowedToStart, ends in about 2 h 01 min',
        '   3 D (small, 10 items): AllowedToStart, ends in about 5 s',
    ]


def test_an_empty_line_says_so() -> None:
    status = statuses.status(jobs=[])
    assert list(lines(status)) == ['nothing is on the line', 'the queue is empty']
