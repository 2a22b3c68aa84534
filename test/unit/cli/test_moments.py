"""Moments on the command line."""

from __future__ import annotations

import argparse

import pytest

from bt_orchestrator.cli.numbers import moment


@pytest.mark.parametrize(
    'text',
    ['', 'now', '2026-13-01', '0001-01-01', '0001-01-01T00:00+14:00', '9999-12-31T23:59-12:00'],
)
def test_invalid_time_is_refused_with_example(text: str) -> None:
    """Some can be read, and have no place in a calendar of another time zone."""
    with pytest.raises(argparse.ArgumentTypeError, match='is not a time; write 2026-05-17'):
        moment(text)


def test_time_of_unset_clock_is_valid() -> None:
    assert moment('1970-01-01T00:00+00:00') == 0.0
    assert moment('2026-05-17T14:30+02:00') == 1779021000.0
