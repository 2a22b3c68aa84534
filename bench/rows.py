"""What a benchmark row says: the median of the rounds, and whether it holds its target."""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Target:
    """One line of the table of targets."""

    name: str
    must: float | None = None
    """None: the figure is shown and held against nothing."""
    goal: float | None = None
    at_least: bool = False
    """The figure has to be as large as the target, or larger."""

    def holds(self, value: float, bound: float | None) -> bool:
        """Tell whether a figure is within a bound."""
        if bound is None:
            return True
        return value >= bound if self.at_least else value <= bound

    def in_words(self, bound: float | None) -> str:
        """Return a bound as it stands in a table."""
        return '' if bound is None else f'{"≥" if self.at_least else "≤"} {bound:,g}'


POOLED = {'latencies, s', 'wraps, s'}
"""Notes that hold every single measurement, by candidate."""

TARGETS = {
    'engine': Target('engine alone, CPU a task, us, journal in memory'),
    'engine_normal': Target('engine alone, CPU a task, us, NORMAL'),
    'engine_against': Target('engine alone / that of --against, journal in memory', 1.05, 0.65),
    'engine_normal_against': Target('engine alone / that of --against, NORMAL', 1.05, 0.65),
    'dispatch': Target(
        'dispatch p50, ours with FULL less a cold durable write / rclpy chain, same executor',
        1.5,
        1.25,
    ),
    'dispatch_normal': Target(
        'dispatch p50, ours / rclpy chain on the same executor, NORMAL', 1.35, 1.15
    ),
    'wrap': Target(
        'cycle wrap p50, ours with FULL less a cold durable write / rclpy chain, same executor',
        1.6,
        1.3,
    ),
    'own_part': Target(
        'own part, wait to first goal, less a cold durable write / chain', 2.5, 1.5
    ),
    'polling': Target('dispatch p50, 100 ms polling tree / ours'),
    'polling_fast': Target('dispatch p50, 10 ms polling tree / ours'),
    'cpu': Target('CPU per task with the forecast, ours / chain, same executor', 1.3, 1.1),
    'postgres_append': Target(
        'append p50, PostgreSQL without a replica / file with FULL, same disk', 1.5, 1.2
    ),
    'postgres_dispatch': Target(
        'dispatch p50, journal in PostgreSQL without a replica / file with FULL', 1.1, 1.0
    ),
    'watcher': Target('dispatch p50, tree watcher attached / without', 1.2, 1.05),
    'page_attached': Target('dispatch p50, page with one reader / without', 1.2, 1.05),
    'opcua_attached': Target('dispatch p50, OPC UA with two subscribers / without', 1.2, 1.05),
    'plain_client': Target('dispatch p50, client plain / ours'),
    'plain_client_cpu': Target('CPU per task, client plain / ours'),
    'page_cpu': Target('CPU, page with one reader / watch on a terminal', 1.5, 1.0),
    'page_node': Target('CPU of the node, with a page that is read / with watch', 1.1, 1.0),
    'page_reader': Target('CPU of the page, with one reader / without'),
    'page_readers': Target('event to reader p95, 20 readers beside 30 stuck / one alone', 2, 1.2),
    'opcua_order': Target('CPU of an order in the OPC UA server, 100 stored / none', 2, 1.2),
    'opcua_node': Target('CPU of an order over OPC UA in the node, 100 stored / none', 2, 1.2),
    'setup_time': Target('set-up time, 300 leaves / 10 leaves on 10 actions', 2, 1.2),
    'setup_memory': Target('memory added, 300 leaves / 10 leaves on 10 actions', 2, 1.2),
    'sections': Target('tick time, 200 sections / 5 sections, 5 working', 3, 1.5),
    'queue': Target('CPU of an order, 800 jobs queued / 20', 2, 1.2),
    'drift_cpu': Target('CPU per task, last tenth / first tenth', 1.2, 1.05),
    'drift_memory': Target('memory, last tenth / first tenth', 1.2, 1.05),
    'idle': Target('idle CPU, ours / rclpy node with a timer of 10 Hz, no clients', 2, 1.3),
    'simulator': Target('simulator, tasks a second', 5_000, 20_000, at_least=True),
    'check': Target('check of 200 sections and 2,000 tasks, s', 2, 0.3),
    'pace': Target(
        'CPU, run of 60 items / pace in closed form, 100 sections', 10, 100, at_least=True
    ),
    'recipe_pace': Target(
        'pace of a generated script, 60 operations / of the best one there is', 1.01, 1.0
    ),
    'recipe_time': Target('generating it, four candidates for each operation, s', 5, 1),
    'recipe_load': Target('dispatch p50, the node generates scripts of recipes / none', 1.2, 1.05),
    'readers': Target('dispatch p50, the journal is read all the time / not', 1.1, 1.02),
    'readers_cpu': Target('CPU of the node a task, the journal is read / not', 1.1, 1.02),
    'report': Target('report of a year by its books, s', 60, 10),
    'restart': Target('restart, journal of many events / empty one', 5, 1.5),
}


@dataclass
class Row:
    """A target, and what each round measured."""

    key: str
    rounds: list[float]
    notes: dict[str, Any] = field(default_factory=dict)
    """Figures that stand behind the ratios."""

    @property
    def target(self) -> Target:
        """What it is held against."""
        return TARGETS[self.key]

    @property
    def value(self) -> float:
        """Median of the rounds."""
        return statistics.median(self.rounds)

    def to_plain(self) -> dict[str, Any]:
        """Return the row as it stands in the JSON file."""
        target, value = self.target, self.value
        return {
            'key': self.key,
            'name': target.name,
            'value': value,
            'must': target.must,
            'goal': target.goal,
            'holds_must': target.holds(value, target.must),
            'holds_goal': target.holds(value, target.goal),
            'rounds': self.rounds,
            'notes': self.notes,
        }

    @property
    def verdict(self) -> str:
        """Which of its bounds the value is within."""
        target, value = self.target, self.value
        if target.must is None:
            return 'shown'
        if not target.holds(value, target.must):
            return 'MISSED'
        return 'goal' if target.holds(value, target.goal) else 'must'

    @property
    def spread(self) -> str:
        """The smallest and the largest of the rounds."""
        return f'{shown(min(self.rounds))} .. {shown(max(self.rounds))}'

    def __str__(self) -> str:
        target = self.target
        held = f'must {target.in_words(target.must)}, goal {target.in_words(target.goal)}: '
        if target.must is None:
            held = ''
        value = f'{shown(self.value):>10}  {self.spread:20}'
        return f'{target.name:66} {value} {held}{self.verdict}'


def merged(runs: Sequence[Sequence[Row]]) -> list[Row]:
    """Return the rows of several runs as if their rounds had been of one.

    Lists in the notes are put together; of single figures, and of curves, the last run's stand.
    """
    rows: dict[str, Row] = {}
    for row in (row for run in runs for row in run):
        before = rows.get(row.key, Row(row.key, []))
        notes = {**before.notes, **row.notes}
        for name in POOLED & before.notes.keys() & row.notes.keys():
            notes[name] = {
                who: [*before.notes[name][who], *values] for who, values in row.notes[name].items()
            }
        rows[row.key] = Row(row.key, [*before.rounds, *row.rounds], notes)
    return list(rows.values())


def shown(value: float) -> str:
    """Return three digits, or all of a large number."""
    return f'{value:,.0f}' if abs(value) >= 1000 else f'{value:.3g}'


def percentile(values: Sequence[float], share: float) -> float:
    """Return the value below which a share of the values lies."""
    ordered = sorted(values)
    return ordered[min(int(len(ordered) * share), len(ordered) - 1)]
