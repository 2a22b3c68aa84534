"""The verb `request` takes what the table of requests declares."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from bt_orchestrator.cli.main import main
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.cli.request import arguments_from
from bt_orchestrator.model.requests import REQUESTS, TABLE


def read(name: str, *words: str) -> dict[str, Any]:
    return arguments_from(REQUESTS[name], words)


def test_each_kind_of_argument_is_read() -> None:
    assert read('job.move', 'job=1001', 'position=2') == {'job': '1001', 'position': 2}
    assert read('cell.resume', 'everyones=yes') == {'everyones': True}
    assert read('cell.clear', 'belt=1=WO-1/3', 'belt=2=empty') == {'belt': ['1=WO-1/3', '2=empty']}
    assert read('hold.mark_done', 'hold=3', 'results.pose.x=1.5', 'results.ok=true') == {
        'hold': '3',
        'results': {'pose': {'x': 1.5}, 'ok': True},
    }
    assert read('job.update', 'params={speed: 3}')['params'] == {'speed': 3}
    assert read('queue.add', 'orders=a.yaml', 'orders=b.yaml') == {
        'orders': [Path('a.yaml'), Path('b.yaml')]
    }


@pytest.mark.parametrize(
    ('words', 'message'),
    [
        (('position',), 'expected job=..., position=...; found .position.'),
        (('place=1',), 'expected job=..., position=...; found .place=1.'),
        (('position=first',), 'expected position=N; found .position=first.'),
        (('position.x=1',), 'expected position=N; found .position.x=1.'),
        (('job=A', 'job=B'), 'job is given twice'),
    ],
)
def test_wrong_arguments_are_told_with_the_right_ones(
    words: tuple[str, ...], message: str
) -> None:
    with pytest.raises(WrongUse, match=message):
        read('job.move', *words)


def test_without_a_name_all_requests_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(['request']) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines if line[0] != ' '] == [row.name for row in TABLE]
    assert '  position=N: place in the queue, from 1 (required)' in lines


@pytest.mark.parametrize(
    ('words', 'message'),
    [
        (('cell.fly',), "there is no request 'cell.fly'; `request` alone lists all"),
        (('job.next', 'job=A'), 'request job.next: say why, with --reason TEXT'),
        (('job.next', '--reason', 'x'), 'job.next needs job: id of the job'),
    ],
)
def test_wrong_use_is_told_before_anything_is_asked(
    words: tuple[str, ...], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(['request', *words]) == 2
    assert message in capsys.readouterr().err
