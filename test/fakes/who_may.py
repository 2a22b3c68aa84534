"""The table `test/data/who_may.csv`: which request is refused for whom, where, why."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Mapping
from enum import Enum
from pathlib import Path
from typing import Any, NamedTuple

from bt_orchestrator.model.by import Role
from bt_orchestrator.model.requests import REQUESTS, Kind

FILE = Path(__file__).parents[1] / 'data' / 'who_may.csv'

ANY = 'because'

OUTCOMES = {'yes', 'no', 'local', 'remote', 'manual', 'production', 'safety'}
"""What a request may be refused for, besides the role; no: the role."""


class Where(Enum):
    """A state of the line, and where somebody stands; the name of a column."""

    MANUAL = 'panel in manual'
    """First: for others the line does not have to stand."""
    REMOTE = 'remote'
    ELSEWHERE = 'elsewhere in local'
    PANEL = 'panel in local'
    UNSAFE = 'panel with safety lost'


class Row(NamedTuple):
    """One row, as somebody wrote it."""

    request: str
    cells: Mapping[str, str]

    def expected(self, role: Role, where: Where) -> str:
        """Return for what the request is refused: role, local, safety, ...; or yes."""
        return self.cells[where.value] if self.cells[role.value] == 'yes' else 'role'


def rows() -> list[Row]:
    """Read the table; it names every request once."""
    lines = [line for line in FILE.read_text().splitlines() if not line.startswith('#')]
    table = [Row(row.pop('request'), row) for row in csv.DictReader(lines)]
    assert [row.request for row in table] == list(REQUESTS)
    assert all(set(row.cells.values()) <= OUTCOMES for row in table)
    return table


_VALUES: Mapping[Kind, Any] = {
    Kind.TEXT: 'none',
    Kind.WHOLE: 1,
    Kind.TEXTS: ['none'],
    Kind.VALUES: {},
    Kind.ORDERS: [{'order': 'W-1', 'script': 'none'}],
}


def arguments(request: str) -> dict[str, Any]:
    """Return arguments with which a request can be asked; its subject is not there."""
    return {arg.name: _VALUES[arg.kind] for arg in REQUESTS[request].parameters if arg.is_required}


_SAID = {
    'is for the role': 'role',
    'which is in local': 'local',
    ', and the line is in remote': 'remote',
    'the cell is in manual mode; end it': 'manual',
    'the cell is not in manual mode': 'production',
    'the safety input is not ready': 'safety',
}


def outcome(message: str) -> str:
    """Return what a refusal is for; yes for any other answer."""
    return next((what for words, what in _SAID.items() if words in message), 'yes')


Ask = Callable[[str, Mapping[str, Any], Role, bool], str]
"""Makes a request with some arguments, by a role, at a panel or not; returns the message."""


def differences(
    ask: Ask, hand_over: Callable[[str], None], lose: Callable[[], object]
) -> Iterator[str]:
    """Ask everything in every column, and yield what is not as the table says.

    :param hand_over: brings the line into local or remote
    :param lose: loses the safety input
    """
    for where in Where:
        if where is Where.MANUAL:
            hand_over('local')
            answer = ask('cell.manual', {}, Role.ENGINEER, True)
            assert 'the cell is in manual mode: it stands' in answer, answer
        if where is Where.UNSAFE:
            lose()
        for row in rows():
            for role in Role:
                if where is not Where.MANUAL:
                    hand_over('remote' if where is Where.REMOTE else 'local')
                is_panel = where.value.startswith('panel')
                answer = ask(row.request, arguments(row.request), role, is_panel)
                expected, actual = row.expected(role, where), outcome(answer)
                if actual != expected:
                    yield f'{row.request} {role.value} {where.value}: {expected}, found {answer}'
        if where is Where.MANUAL:
            answer = ask('cell.production', {'as_shown': 1}, Role.ENGINEER, True)
            assert 'manual mode has ended' in answer, answer
