"""Accounts side by side: a column a day or a shift, with the trend, the best and the worst.

The rows are the figures of the line, or those of each product, job or component.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import combinations
from statistics import median
from typing import NamedTuple

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.view.report.account.account import Account, NothingToReport, account
from bt_orchestrator.view.report.account.figures import Bar, Figures
from bt_orchestrator.view.report.account.losses import WORDS, Loss, Step
from bt_orchestrator.view.report.account.named_figures import (
    OF_LINE,
    By,
    Figure,
    Unit,
    names_of,
    of_loss,
    of_named,
    of_parts,
)
from bt_orchestrator.view.report.account.period import Period
from bt_orchestrator.view.report.account.planned import Planned
from bt_orchestrator.view.report.account.stops import Held, Stop
from bt_orchestrator.view.report.account.words import is_seen
from bt_orchestrator.view.report.line_stops import ReasonShare, ReasonSum, shares
from bt_orchestrator.view.report.reading import Reading

FEWEST_FOR_TREND = 3
"""With fewer known columns there is no trend: two always lie on a line."""

MOST_LOSSES = 3
"""Losses with their stops and holds."""


class Row(NamedTuple):
    """One figure in every column."""

    name: str
    """As JSON and CSV carry it."""
    title: str
    unit: Unit
    values: tuple[Fraction | None, ...]
    together: Fraction | None
    """Of all columns: a ratio of sums, no mean of ratios."""
    target: Fraction | None = None

    @property
    def trend(self) -> Fraction | None:
        """The change from a column to the next: the median over all pairs (Theil and Sen).

        A single bad day does not turn it. None: fewer than three columns are known.
        """
        known = [(at, value) for at, value in enumerate(self.values) if value is not None]
        if len(known) < FEWEST_FOR_TREND:
            return None
        return median((b - a) / (later - at) for (at, a), (later, b) in combinations(known, 2))

    @property
    def reached(self) -> int:
        """How many columns reached the target."""
        assert self.target is not None
        return sum(value >= self.target for value in self.values if value is not None)


class Group(NamedTuple):
    """The rows of one product, job or component; of the line, if it has no name."""

    name: str
    rows: tuple[Row, ...]

    @property
    def has_targets(self) -> bool:
        """Tell whether the plant wants something of any row."""
        return any(row.target is not None for row in self.rows)


class Column(NamedTuple):
    """One period; without an account the journal has nothing of it."""

    title: str
    period: Period
    account: Account | None


class Largest(NamedTuple):
    """One of the largest losses, with what caused it."""

    bar: Bar
    stops: tuple[Stop, ...]
    holds: tuple[Held, ...]
    reasons: tuple[ReasonShare, ...]
    """Of its stops, the longest first; empty: no stop of it has a reason."""

    @property
    def is_open(self) -> bool:
        """Tell whether a hold of it has no answer yet."""
        return any(held.released_us is None for held in self.holds)


@dataclass(frozen=True)
class Beside:
    """A report with several columns, or with one."""

    columns: tuple[Column, ...]
    together: Account

    @property
    def known(self) -> tuple[Column, ...]:
        """The columns with an account."""
        return tuple(column for column in self.columns if column.account is not None)

    def groups(self, by: By | None) -> tuple[Group, ...]:
        """Return all rows."""
        if by is None:
            return (Group('', self._of_line()),)
        return tuple(
            Group(name, tuple(map(self._row, of_named(name, by))))
            for name in names_of(self.together.figures, by)
        )

    def _of_line(self) -> tuple[Row, ...]:
        losses = (
            figure
            for loss in Loss
            if self._is_seen(of_loss(loss))
            for figure in (of_loss(loss), *filter(self._is_seen, of_parts(loss)))
        )
        return tuple(map(self._row, (*OF_LINE, *losses)))

    def _is_seen(self, figure: Figure) -> bool:
        values = (figure.tell(shown) or 0 for shown in self._figures)
        return any(is_seen(value) if figure.unit is Unit.SECONDS else value for value in values)

    @property
    def _figures(self) -> list[Figures]:
        return [column.account.figures for column in self.columns if column.account is not None]

    def _row(self, figure: Figure) -> Row:
        def value(made: Account | None) -> Fraction | None:
            number = None if made is None else figure.tell(made.figures)
            return None if number is None else Fraction(number)

        return Row(
            figure.name,
            figure.title,
            figure.unit,
            tuple(value(column.account) for column in self.columns),
            value(self.together),
            self.together.period.targets.get(figure.name),
        )

    def extremes(self) -> tuple[Column, Column] | None:
        """Return the best and the worst column, by OEE; without a pace by availability.

        None: fewer than two columns are known, or all are equal.
        """
        for row in self._of_line()[:2]:
            known = [
                (value, column)
                for value, column in zip(row.values, self.columns, strict=True)
                if value is not None
            ]
            if len({value for value, _ in known}) > 1:
                best = max(known, key=lambda pair: pair[0])
                return best[1], min(known, key=lambda pair: pair[0])[1]
        return None

    def largest(self) -> tuple[Largest, ...]:
        """Return the losses of busy time that took most, with what caused each of them."""
        shown = self.together.figures
        busy = (
            bar
            for bar in shown.steps_seen()
            if bar.loss is not None and WORDS[bar.loss].step is not Step.NOT_BUSY and bar.us > 0
        )
        bars = sorted(busy, key=lambda record: -record.us)[:MOST_LOSSES]
        return tuple(
            Largest(
                bar,
                tuple(
                    stop for stop in shown.times.stops if stop.loss is bar.loss and stop.is_shown
                ),
                tuple(
                    sorted(
                        (hold for hold in shown.times.holds if hold.loss is bar.loss),
                        key=lambda record: -record.lost_us,
                    )
                ),
                _reasons(reason for reason in shown.times.by_reason if reason.loss is bar.loss),
            )
            for bar in bars
        )


def _reasons(sums: Iterable[ReasonSum]) -> tuple[ReasonShare, ...]:
    reasons = shares(sums)
    return reasons if any(reason.code for reason in reasons) else ()


def beside(reading: Reading, periods: Sequence[tuple[str, Period]], cell: Cell | None) -> Beside:
    """Make the accounts of periods, in their order, and the one of all together.

    :param periods: each with the title of its column
    :raises NothingToReport: the journal has nothing of any of them
    """
    if len(periods) == 1:
        [(title, period)] = periods
        made = account(reading, period, cell)
        return Beside((Column(title, made.period, made),), made)
    together = account(reading, _together([period for _, period in periods]), cell)
    columns = tuple(_column(reading, title, period, cell) for title, period in periods)
    return Beside(columns, together)


def _together(periods: Sequence[Period]) -> Period:
    first, last = periods[0], periods[-1]
    return replace(
        first,
        name=f'{first.name} to {last.name}',
        begin_us=min(period.begin_us for period in periods),
        end_us=max(period.end_us for period in periods),
        planned=Planned.of([piece for period in periods for piece in period.cut().planned.pieces]),
        breaks=tuple(dict.fromkeys(pause for period in periods for pause in period.breaks)),
    )


def _column(reading: Reading, title: str, period: Period, cell: Cell | None) -> Column:
    try:
        made = account(reading, period, cell)
    except NothingToReport:
        return Column(title, period, None)
    return Column(title, made.period, made)
