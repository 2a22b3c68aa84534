"""The view of a cell: what a status means to a person who watches, without any drawing."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, NamedTuple

from bt_orchestrator.model.jobs.isa95 import OVER
from bt_orchestrator.screen import words
from bt_orchestrator.screen.advice import Shell, hold_advice, next_lines


class Weight(IntEnum):
    """How much a row matters where there is no room for all of them; the smallest stays."""

    HELD = 0
    WORKING = 1
    WAITING_WITH_ITEM = 2
    WAITING = 3
    ENDED = 4


class Slot(NamedTuple):
    """What the belt carries at a section."""

    name: str
    """Of an item; in brackets if it is not there; empty: nothing."""
    is_rejected: bool = False
    is_nonconforming: bool = False


@dataclass(frozen=True)
class Row:
    """One line about a section: a task in flight, or a reason for waiting."""

    section: int
    slot: str
    text: str
    weight: Weight
    elapsed_s: float | None
    """Of a task, when the status was made."""


@dataclass(frozen=True)
class JobRow:
    """One line about a job."""

    id: str
    script: str
    state: str
    counts: str
    packed: float
    """Share of the quantity that has left the line, good or bad."""
    on_line: float
    """Share of the quantity that is on its way."""
    weight: Weight


@dataclass(frozen=True)
class HoldRow:
    """Something that waits for an operator, with what can be typed."""

    text: str
    advice: tuple[str, ...]


@dataclass(frozen=True)
class CellView:
    """Everything that is shown of one status."""

    cell: str
    state: str
    failure: str
    """Why nothing is done any more; empty: all is well."""
    stopped: str
    """Who wants the cell to stand; empty: nobody."""
    belt: str
    belt_waiting: tuple[str, ...]
    made_at: float
    """The node's time, seconds since the epoch."""
    slots: tuple[Slot, ...]
    """In the direction of travel."""
    rows: tuple[Row, ...]
    initialization: tuple[str, ...]
    jobs: tuple[JobRow, ...]
    unlisted_jobs: int
    """How many jobs of the queue have no row."""
    holds: tuple[HoldRow, ...]
    next_lines: tuple[str, ...]
    """What can be typed where the cell stands and waits for somebody."""
    troubles: tuple[str, ...]
    flags: tuple[str, ...]

    @property
    def is_held(self) -> bool:
        """Tell whether somebody has to decide something."""
        return bool(self.holds)


def cell_view(status: Any, shell: Shell) -> CellView:
    """Return the view of a status (bt_orchestrator_interfaces/msg/Status).

    :param shell: for the command lines
    """
    return CellView(
        cell=words.one_line(status.cell),
        state=status.state,
        failure=words.failure(status),
        stopped=words.stopped(status),
        belt=words.belt(status),
        belt_waiting=tuple(map(words.one_line, status.belt_waiting)),
        made_at=_seconds(status.stamp),
        slots=tuple(map(_slot, status.sections)),
        rows=tuple(row for section in status.sections for row in _rows(section, status)),
        initialization=tuple(map(words.one_line, status.initialization_waiting)),
        jobs=tuple(_job(job, status) for job in status.jobs),
        unlisted_jobs=words.unlisted(status),
        holds=tuple(
            HoldRow(words.hold_text(hold), tuple(hold_advice(hold, shell)))
            for hold in status.holds
        ),
        next_lines=tuple(next_lines(status, shell)),
        troubles=tuple(words.troubles(status)),
        flags=tuple(map(words.flag_count, status.flags)),
    )


def _slot(section: Any) -> Slot:
    return Slot(words.slot(section), section.slot_rejected, len(section.slot_nonconforming) > 0)


def _rows(section: Any, status: Any) -> Iterator[Row]:
    """Yield what a section does and what it waits for; at least one row.

    The first one says what is wrong with the item in the slot.
    """
    number, slot = section.section, words.slot(section)
    fate = words.fate(section)
    for task in section.running:
        elapsed_s = max(_seconds(status.stamp) - _seconds(task.started), 0.0)
        text = '; '.join(filter(None, [fate, words.task(task)]))
        yield Row(number, slot, text, Weight.WORKING, elapsed_s)
        fate = ''
    weight = Weight.WAITING_WITH_ITEM if slot or section.item else Weight.WAITING
    if any(hold.section == number for hold in status.holds):
        weight = Weight.HELD
    if section.waiting or not section.running:
        said = [fate, *map(words.one_line, section.waiting)]
        reasons = '; '.join(filter(None, said))
        yield Row(number, slot, reasons, weight, None)


def _job(job: Any, status: Any) -> JobRow:
    out = job.packed + job.rejected + job.missing
    on_line = max(job.started - out, 0)
    quantity = max(job.quantity, 1)
    ended = job.state in OVER
    weight = Weight.ENDED if ended else Weight.WORKING if job.started else Weight.WAITING
    return JobRow(
        id=words.one_line(job.id),
        script=words.one_line(job.script),
        state=job.state,
        counts=words.job_counts(job) + words.expected_finish(job, status),
        packed=min(out / quantity, 1.0),
        on_line=min(on_line / quantity, 1.0),
        weight=weight,
    )


def _seconds(time: Any) -> float:
    return float(time.sec + time.nanosec / 1e9)
