"""The verb `queue`: what it prints, and wrong use, which needs no node."""

from __future__ import annotations

from datetime import datetime

import pytest
from fakes import statuses

from bt_orchestrator.cli.main import main
from bt_orchestrator.cli.queue import lines
from bt_orchestrator.model.jobs.isa95 import JobWord

DUE = 1779084000.0
WHY = ['--reason', 'rush']


@pytest.mark.parametrize(
    ('words', 'told'),
    [
        (['hold', 'a'], 'say why, with --reason TEXT'),
        (['hold', *WHY], 'expected one job, found nothing'),
        (['requeue', '--as', 'B', *WHY], 'expected one job, found nothing'),
        (['list', 'a'], 'expected nothing, found a'),
        (['add'], 'name at least one order'),
        (['move', 'a', *WHY], 'expected a job and its place, found a'),
        (
            ['move', 'a', 'first', *WHY],
            'the place: expected a whole number',
        ),
        (['update', 'a', *WHY], 'say what to change'),
        (['update', 'a', '--param', 'lot', *WHY], "--param is NAME=VALUE; found 'lot'"),
        (['update', 'a', '--details', '{"a": NaN}', *WHY], '`details` must have finite numbers'),
        (['update', 'a', '--details', '{"a"', *WHY], '`details` must be JSON'),
        (['update', 'a', '--details', '/no/such/file', *WHY], 'No such file'),
        (['update', 'a', '--details', '/dev/zero', *WHY], 'this is a pipe or a device'),
        (['hold', 'a', '--at', '3', *WHY], 'queue hold: --at is for queue add'),
        (['update', 'a', '--held', *WHY], 'queue update: --held is for queue add'),
        (['list', '--as', 'B'], 'queue list: --as is for queue requeue'),
        (['add', 'a', '--priority', '0'], 'queue add: --priority is for queue update'),
        (['stop-after', 'lunch', *WHY], "one of item, job, never; found 'lunch'"),
    ],
)
def test_wrong_use_is_told(
    words: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(['queue', *words]) == 2
    assert told in capsys.readouterr().err


@pytest.mark.parametrize(
    ('option', 'told'),
    [
        ('--priority=32768', "expected a whole number from -32768 to 32767, found '32768'"),
        ('--priority=1.5', "expected a whole number from -32768 to 32767, found '1.5'"),
        ('--start=2026-05-18T06:00', 'write 2026-05-18T06:00Z for UTC, or the offset'),
        ('--due=2039-01-01T00:00Z', 'expected between 1970 and 2038, found'),
    ],
)
def test_a_wrong_value_is_told(option: str, told: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match='2'):
        main(['queue', 'update', 'a', option, *WHY])
    assert told in capsys.readouterr().err


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
