"""What came of an attacked line, phase by phase."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from attack.measured import Figures


@dataclass
class Phase:
    """One attack, and how the line bore it."""

    name: str
    seconds: float = 0.0
    figures: Figures = field(default_factory=Figures)
    tasks: int = 0
    """Tasks of the line that succeeded meanwhile."""
    counts: Mapping[str, int] = field(default_factory=dict)
    """What the attacker did."""
    faults: list[str] = field(default_factory=list)

    def __str__(self) -> str:
        did = ', '.join(f'{number:,} {what}' for what, number in self.counts.items())
        return f'{_row(self)}  {did}'


@dataclass
class Outcome:
    """All phases, and what the controllers and the journal say at the end."""

    phases: list[Phase] = field(default_factory=list)
    orders: int = 0
    items: int = 0
    seconds: float = 0.0
    faults: list[str] = field(default_factory=list)
    """Of which nobody knows to which phase they belong."""

    @property
    def all_faults(self) -> list[str]:
        """Every fault, with the phase that is guilty."""
        named = [f'{phase.name}: {fault}' for phase in self.phases for fault in phase.faults]
        return [*named, *self.faults]

    def as_plain(self) -> dict[str, Any]:
        """Return all of it, for JSON."""
        return {**asdict(self), 'all_faults': self.all_faults}

    def lines(self) -> Iterator[str]:
        """Yield the table, and every fault."""
        yield HEAD
        yield from map(_row, self.phases)
        yield f'{self.orders} orders, {self.items} items packed, {self.seconds:.0f} s'
        yield f'{len(self.all_faults)} faults'
        yield from self.all_faults


_COLUMNS = (
    'pings',
    'p50 ms',
    'p99 ms',
    'max ms',
    'plain',
    'excess',
    'peak MB',
    'journal',
    'tasks',
)

HEAD = f'{"phase":15}{"s":>5}' + ''.join(f'{name:>9}' for name in _COLUMNS) + '  faults'


def _row(phase: Phase) -> str:
    f = phase.figures
    times = (f.p50_ms, f.p99_ms, f.max_ms, f.plain_max_ms, f.excess_ms)
    shown = ''.join(f'{value:9.0f}' for value in times)
    sizes = f'{f.peak_mb:9.1f}{f.journal_mb:9.2f}{phase.tasks:9}'
    return f'{phase.name:15}{phase.seconds:5.0f}{f.pings:9}{shown}{sizes}{len(phase.faults):8}'
