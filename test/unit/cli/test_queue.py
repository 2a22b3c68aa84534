"""The verb `queue`: what it prints, and wrong use, which needs no node."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from bt_orchestrator.cli.main import main
from bt_orchestrator.cli.queue import lines

WHY = ['--reason', 'rush']


@pytest.mark.parametrize(
    ('words', 'told'),
    [
        (['hold', 'a'], 'say why, with --reason TEXT'),
        (['hold', *WHY], 'expected one job, found nothing'),
        (['list', 'a'], 'expected nothing, found a'),
        (['add'], 'name at least one order'),
        (['move', 'a', *WHY], 'expected a job and its place, found a'),
        (
            ['move', 'a', 'first', *WHY],
            'the place: expected a whole number',
        ),
        (['update', 'a', *WHY], 'say what to change'),
        (['update', 'a', '--param', 'lot', *WHY], "--param is NAME=VALUE; found 'lot'"),
        (['stop-after', 'lunch', *WHY], "one of item, job, never; found 'lunch'"),
    ],
)
def test_wrong_use_is_told(
    words: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(['queue', *words]) == 2
    assert told in capsys.readouterr().err


def job(name: str, position: int, state: str, **fields: object) -> SimpleNamespace:
    """Return what a JobStatus says."""
    plain = {'substate': '', 'ending': '', 'expected_end_s': -1.0, 'packed': 0, **fields}
    return SimpleNamespace(
        id=name, script='boxes', quantity=4, position=position, state=state, **plain
    )


def test_running_jobs_stand_apart_from_the_queue() -> None:
    status = SimpleNamespace(
        stop_after='job',
        jobs=[
            job('A', 0, 'Running', packed=2, ending='stopping', expected_end_s=61.4),
            job('B', 1, 'NotAllowedToStart'),
            job('C', 2, 'AllowedToStart', expected_end_s=7265.0),
            job('D', 0, 'Ended'),
        ],
    )
    assert list(lines(status)) == [
        'the cell stops after the current job',
        'on the line:',
        '     A (boxes, 4 items): Running/stopping, ends in about 1 min 01 s, 2 packed',
        'queue:',
        '   1 B (boxes, 4 items): NotAllowedToStart',
        '   2 C (boxes, 4 items): AllowedToStart, ends in about 2 h 01 min',
    ]


def test_an_empty_line_says_so() -> None:
    status = SimpleNamespace(stop_after='', jobs=[])
    assert list(lines(status)) == ['nothing is on the line', 'the queue is empty']
