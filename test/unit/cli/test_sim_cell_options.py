"""Options of the verb `sim-cell`."""

from __future__ import annotations

import argparse
from pathlib import Path

import pytest

from bt_orchestrator.cli.sim_cell import add_arguments
from bt_orchestrator.model.fault import FaultKind


@pytest.fixture
def parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog='bt-orchestrator sim-cell')
    add_arguments(parser)
    return parser


def test_a_cell_file_is_enough(parser: argparse.ArgumentParser) -> None:
    args = parser.parse_args(['--cell', 'config/cell.yaml'])

    assert args.cell == Path('config/cell.yaml')
    assert (args.speed, args.only, args.fail, args.log, args.namespace) == (1.0, [], [], None, '')


def test_options_are_read(parser: argparse.ArgumentParser) -> None:
    text = '--cell c.yaml --speed 2.5 --only a,b --only c --fail a#1=hang --fail b=mute'
    more = '--log goals.jsonl --namespace /cell_b/ --feedback 0 --result-timeout 900'
    args = parser.parse_args([*text.split(), *more.split()])

    assert (args.speed, args.only, args.fail) == (2.5, ['a,b', 'c'], ['a#1=hang', 'b=mute'])
    assert (args.log, args.namespace) == (Path('goals.jsonl'), '/cell_b')
    assert (args.feedback, args.result_timeout) == (0.0, 900.0)


@pytest.mark.parametrize(
    'option',
    [
        *('--speed=0', '--speed=-1', '--speed=inf', '--speed=nan', '--speed=x', '--feedback=-1'),
        *('--namespace=a b', '--namespace=1a', '--namespace=a//b', '--namespace=a-b'),
    ],
)
def test_values_that_cannot_be_are_refused(
    parser: argparse.ArgumentParser, option: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        parser.parse_args(['--cell', 'c.yaml', option])

    assert ended.value.code == 2
    assert 'expected' in capsys.readouterr().err


def test_the_help_explains_every_fault(parser: argparse.ArgumentParser) -> None:
    explained = [line.split()[0] for line in parser.format_help().splitlines() if line.split()]

    for kind in FaultKind:
        assert any(word.split('[')[0].split(':')[0] == kind.value for word in explained), kind
