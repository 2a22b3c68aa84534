"""One slot of an account while it is added up."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import replace

from bt_orchestrator.model import events as e
from bt_orchestrator.model.task_spans import TaskSpan
from bt_orchestrator.view.report.account.course import Stretch, is_busy
from bt_orchestrator.view.report.account.losses import Loss
from bt_orchestrator.view.report.account.made import Left, Made, count
from bt_orchestrator.view.report.account.slot import FailedSum, RestOfHolds, Slot, StopSum
from bt_orchestrator.view.report.account.stops import MOST_HOLDS, Held, without_times


class OpenSlot:
    """Takes in stretches of time, and what happens, from one moment to another."""

    def __init__(self, begin: int, ends: int, cell: str, digest: str) -> None:
        """Begin.

        :param ends: when it ends at the latest
        :param cell: name and digest of the cell that the node runs with; empty: not known
        """
        self.begin, self.ends, self.now = begin, ends, begin
        self._producing = 0
        self._stops: dict[tuple[Loss, str, str], StopSum] = {}
        self._held: dict[str, Held] = {}
        self._released: list[Held] = []
        self._before: set[str] = set()
        """Holds that had been raised before."""
        self._made: dict[tuple[str, str], Made] = {}
        self._failed: Counter[tuple[str, str, str]] = Counter()
        self._took: Counter[tuple[str, str, str]] = Counter()
        self._cell = cell
        self._cells = dict.fromkeys([digest] if digest else ())
        self._is_steady = True

    def go_on_from(self, slot: Slot) -> None:
        """Know what a slot that was not complete has added up."""
        self.now, self._producing = slot.until_us, slot.producing_us
        self._stops = {(one.loss, one.detail, one.component): one for one in slot.stops}
        self._released = [one for one in slot.holds if one.released_us is not None]
        self._held = {one.hold: one for one in slot.holds if one.released_us is None}
        self._before = {one.hold for one in slot.holds if one.raised_us <= slot.begin_us}
        self._made = {(one.job, one.digest): one for one in slot.made}
        for one in slot.failed:
            key = (one.component, one.task, one.reason)
            self._failed[key], self._took[key] = one.times, one.us
        self._cell, self._cells = slot.cell, dict.fromkeys(slot.cells)
        self._is_steady = slot.is_steady
        self._rest_before = slot.rest

    _rest_before: tuple[RestOfHolds, ...] = ()

    def passes(self, stretch: Stretch, holds: Iterable[Held]) -> None:
        """Let time pass, within the slot.

        :param holds: that stand
        """
        us, cause = stretch.end - stretch.begin, stretch.cause
        is_first = self.now == self.begin
        self._is_steady &= is_first or stretch.goes_on
        self.now = stretch.end
        if cause is None:
            self._producing += us
        else:
            stop = self._stops.setdefault(cause[:3], StopSum(*cause[:3]))
            stop.us += us
            stop.begun += not stretch.goes_on
            stop.goes_on |= stretch.goes_on and is_first
        busy = is_busy(cause)
        for one in holds:
            held = self._held.get(one.hold) or self._stands(one, is_first=is_first)
            held.stood_us += us
            if cause is not None and cause.hold == one.hold:
                held.loss = cause.loss
                held.lost_us += us
            if one.component and busy:
                held.down_us += us

    def _stands(self, held: Held, *, is_first: bool) -> Held:
        if is_first:
            self._before.add(held.hold)
        self._held[held.hold] = made = without_times(held)
        return made

    # --- what happens -------------------------------------------------------------------------

    def raised(self, held: Held, *, is_busy: bool) -> None:
        """Take in a hold."""
        self._is_steady = False
        self._stands(held, is_first=False).fails = bool(held.component) and is_busy

    def released(self, held: Held) -> None:
        """Take in that a hold is over."""
        self._is_steady = False
        sums = self._held.pop(held.hold, None)
        if sums is not None:
            sums.told_as(held)
            self._released.append(sums)

    def failed(self, event: e.TaskFailed, span: TaskSpan | None) -> None:
        """Take in an attempt that failed."""
        self._is_steady = False
        begun = span.started if span is not None else None
        key = (begun.component if begun else '', begun.name if begun else event.task, event.reason)
        self._failed[key] += 1
        self._took[key] += max(0, round(span.seconds * 1e6)) if span is not None else 0

    def left(self, item: Left) -> None:
        """Take in an item that left the line."""
        self._is_steady = False
        key = (item.of.job, item.of.digest)
        count(self._made.setdefault(key, replace(item.of)), item)

    def runs(self, cell: str, digest: str) -> None:
        """Take in that a node began to run with a cell file."""
        self._is_steady = False
        self._cell = cell
        self._cells[digest] = None

    # --- the slot -----------------------------------------------------------------------------

    def slot(self, open_holds: Iterable[Held]) -> Slot:
        """Return it, as far as it has gone.

        :param open_holds: that stand, as they are told by now
        """
        for one in open_holds:
            if one.hold in self._held:
                self._held[one.hold].told_as(one)
        holds, rest = self._told()
        return Slot(
            self.begin,
            self.now,
            self._producing,
            tuple(self._stops.values()),
            holds,
            rest,
            tuple(self._made.values()),
            tuple(FailedSum(*key, n, self._took[key]) for key, n in self._failed.items()),
            self._cell,
            tuple(self._cells),
            self._is_steady,
        )

    def _told(self) -> tuple[tuple[Held, ...], tuple[RestOfHolds, ...]]:
        """Return the holds to tell one by one, and the sums of the others.

        Those that began or end in other slots are told in any case.
        """
        if len(self._released) <= MOST_HOLDS:
            return (*self._released, *self._held.values()), self._rest_before
        within = [one for one in self._released if one.hold not in self._before]
        within.sort(key=lambda one: (-one.lost_us, -one.stood_us))
        left_out = within[MOST_HOLDS:]
        gone = {one.hold for one in left_out}
        told = [one for one in self._released if one.hold not in gone]
        rests = {(one.loss, one.component): replace(one) for one in self._rest_before}
        for one in left_out:
            rest = rests.setdefault(
                (one.loss, one.component), RestOfHolds(one.loss, one.component)
            )
            rest.told += bool(one.stood_us)
            rest.lost_us += one.lost_us
            rest.failures += bool(one.component and (one.fails or one.down_us))
            rest.down_us += one.down_us
        return (*told, *self._held.values()), tuple(rests.values())
