"""The faults of simulated controllers."""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import Enum

EVERY = -1
"""`nth` of a fault that strikes every time, written `#*`."""


class FaultKind(Enum):
    """The kinds of faults, as the orchestrator sees them."""

    FALSE = 'false'
    """The goal ends SUCCEEDED with `task_result: false`; with words, as in `abort`."""
    REJECT = 'reject'
    """The server refuses the goal."""
    ABORT = 'abort'
    """The goal ends ABORTED after its nominal duration. The text behind `abort:` is the
    controller's: `message` of the Result, else its first text."""
    CANCEL = 'cancel'
    """The goal ends CANCELED after its nominal duration, and the orchestrator did not ask for it:
    the task is held as `in_doubt`. Words as in `abort`."""
    HANG = 'hang'
    """The goal does not end by itself; a cancel request is obeyed."""
    IGNORE_CANCEL = 'ignore_cancel'
    """The goal does not end by itself, and cancel requests are refused."""
    LATE = 'late'
    """The goal ends well, `seconds` later than its nominal duration."""
    READS = 'reads'
    """The goal ends well, and every float of its result is the number behind `reads:`; without
    one it is NaN. It also stands for `{n}` in the texts of the cell file."""
    MUTE = 'mute'
    """The goal request is never answered and nothing is executed."""
    DIE = 'die'
    """The server dies after accepting; with `seconds` it is back after so long, knowing
    nothing."""
    ABSENT = 'absent'
    """The server is not there at first; with `seconds` it comes after so long. Only `#0`."""
    NOT_READY = 'not_ready'
    """The state topic says not ready, for `seconds` or for good, from the goal's end (`#0`: from
    the start) on."""
    SILENT = 'silent'
    """Nothing is ever published on the state topic. Only `#0`."""


WITH_WORDS = (FaultKind.FALSE, FaultKind.ABORT, FaultKind.CANCEL)
"""Kinds with which the controller may say something of its own."""

AT_START = (FaultKind.ABSENT, FaultKind.SILENT)
"""Kinds that only make sense from the start."""


@dataclass(frozen=True)
class Fault:
    """One fault of one component."""

    kind: FaultKind
    task: str | None = None
    """Task constant it strikes at; None: any."""
    nth: int = 1
    """Strikes at the nth goal counted from 1 (of `task`, if given); 0: from the start; EVERY."""
    seconds: float | None = None
    """Of READS it is the number that is read."""
    words: str = ''
    """Words of the controller in its result."""

    def strikes(self, task: str, count: int, count_of_task: int) -> bool:
        """Tell whether it strikes at a goal.

        :param count: which goal of this component it is, from 1
        :param count_of_task: which goal of this task constant it is, from 1
        """
        if self.task is not None and self.task != task:
            return False
        return self.nth in (EVERY, count if self.task is None else count_of_task)


_SPEC = re.compile(
    r'(?P<task>[A-Za-z]\w*)?(?:#(?P<nth>\d+|\*))?=(?P<kind>[a-z_]+)(?::(?P<more>.+))?'
)
_NUMBER = re.compile(r'-?\d+(\.\d+)?')


def parse_fault(text: str) -> Fault:
    """Read `[TASK][#NTH]=KIND[:SECONDS|:WORDS]`, for instance `TASK_A#2=late:3.5`; NTH may be `*`.

    :raises ValueError: says what was expected
    """
    match = _SPEC.fullmatch(text.strip())
    if match is None:
        raise ValueError(_written(text))
    try:
        kind = FaultKind(match['kind'])
    except ValueError:
        kinds = ', '.join(k.value for k in FaultKind)
        raise ValueError(f'unknown fault {match["kind"]!r}; one of {kinds}') from None
    nth = 0 if kind in AT_START else 1
    if match['nth'] is not None:
        nth = EVERY if match['nth'] == '*' else int(match['nth'])
    if (kind in AT_START) != (nth == 0) and kind is not FaultKind.NOT_READY:
        first = '#0' if kind in AT_START else '#1'
        raise ValueError(f'{kind.value} counts from {first}; found #{match["nth"]}')
    if kind in WITH_WORDS:
        return Fault(kind, match['task'], nth, words=match['more'] or '')
    if match['more'] is not None and not _NUMBER.fullmatch(match['more']):
        raise ValueError(_written(text))
    seconds = None if match['more'] is None else float(match['more'])
    if kind is FaultKind.LATE and seconds is None:
        raise ValueError('late needs seconds, as in =late:3.5')
    if kind is not FaultKind.READS and seconds is not None and seconds < 0:
        raise ValueError(f'{kind.value} cannot take {seconds:g} seconds; write 0 or more')
    return Fault(kind, match['task'], nth, seconds)


def _written(text: str) -> str:
    words = '; WORDS behind false, abort and cancel'
    return f'a fault is written [TASK][#NTH]=KIND[:SECONDS]{words}, found {text!r}'
