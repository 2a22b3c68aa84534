"""The proof that scripts cannot get stuck, and the refusal of those that can (semantics 8.2).

By 3.2, 4.1, 4.2 and 5.2 data never changes the flag and belt operations, and durations only change
when they happen, not whether. So the order relations are the same in every run, and decide without
one; docs/deadlock_proof.md has the argument and its conditions.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from bt_orchestrator.model.proof.circle import Stand, circle_of_waits
from bt_orchestrator.model.proof.operations import Operations
from bt_orchestrator.model.proof.precedence import Precedence
from bt_orchestrator.model.proof.remedy import remedy, swapped
from bt_orchestrator.model.proof.standstill import first_standstill, gets_stuck
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.wait import WaitKind


@dataclass(frozen=True)
class Deadlock:
    """How a script gets stuck."""

    script: str
    item: int
    """The last item that the source can begin, counted from 1."""
    beat: int
    """The beat that the belt cannot end."""
    circle: tuple[Stand, ...]
    remedy: str
    """The smallest change of one flag that frees the line; empty: there is none."""
    swapped: str = ''
    """Flag whose ends look swapped; empty: none."""

    @property
    def flags(self) -> tuple[str, ...]:
        """Flags that are waited for in the circle."""
        return _flags_in(self.circle)

    @property
    def hint(self) -> str:
        """The remedy."""
        counts = self.remedy or 'no larger capacity or initial count of one flag frees it'
        if not self.swapped:
            return counts
        return f'swap `upstream` and `downstream` of flag {self.swapped}; or {counts}'

    def __str__(self) -> str:
        waits = '; '.join(map(str, self.circle))
        return (
            f'the line gets stuck with {self.script}, at item {self.item} in beat {self.beat}: '
            f'{waits}'
        )


def deadlock(script: Script) -> Deadlock | None:
    """Return how a script gets stuck; None: it is proven that it cannot."""
    if not script.dependencies:
        return None  # everything waits only for the belt, and the belt for what always ends
    operations = Operations(script)
    line = Precedence([operations])
    still = first_standstill(line)
    if still is None:
        return None
    circle = circle_of_waits(operations, line, still)
    return Deadlock(
        script=script.name,
        item=still.first_never[operations.begins[operations.source]] - 1,
        beat=still.beat,
        circle=circle,
        remedy=remedy(operations, _flags_in(circle)),
        swapped=swapped(operations, _flags_in(circle)),
    )


def get_stuck_together(scripts: Iterable[Script]) -> bool:
    """Tell whether jobs of these scripts can get stuck only behind each other.

    Scripts that share no flag cannot.
    """
    operations: list[Operations] = []
    for script in scripts:
        if script.dependencies:
            operations.append(Operations(script, sum(len(one.all) for one in operations)))
    if len(operations) < 2 or any(gets_stuck(Precedence([one])) for one in operations):
        return False
    return gets_stuck(Precedence(operations))


def _flags_in(circle: tuple[Stand, ...]) -> tuple[str, ...]:
    return tuple(one.wait.name for one in circle if one.wait.kind is WaitKind.FLAG)
