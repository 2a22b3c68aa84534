"""A log that messages of others cannot fill."""

from __future__ import annotations

from bt_orchestrator.ports.spare_log import SpareLog


class Lines:
    """A log."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def error(self, message: str) -> None:
        self.lines.append(message)

    warning = error


def test_a_flood_leaves_the_first_lines() -> None:
    log = Lines()
    spare = SpareLog(log)
    for number in range(10_000):
        spare.error(f'{number}')
        spare.warning(f'{number} again')
    assert log.lines[:2] == ['0', '0 again']
    assert 50 <= len(log.lines) <= 60


def test_a_long_line_is_cut() -> None:
    log = Lines()
    SpareLog(log).warning('x' * 5_000_000)
    assert len(log.lines[0]) == 2000
