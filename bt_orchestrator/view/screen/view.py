"""The view of a cell: what a status means to a person who watches, without any drawing."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

from bt_orchestrator.model.jobs.isa95 import OVER
from bt_orchestrator.model.status import CellStatus, ItemStatus, JobStatus, SectionStatus
from bt_orchestrator.model.status_words import job_count_words, script_words
from bt_orchestrator.model.texts import one_line
from bt_orchestrator.view.screen import words
from bt_orchestrator.view.screen.advice import Shell, alike_lines, next_lines


class Weight(IntEnum):
    """How much a row matters where there is no room for all of them; the smallest stays."""

    HELD = 0
    WORKING = 1
    WAITING_WITH_ITEM = 2
    WAITING = 3
    ENDED = 4


class Slot(NamedTuple):
    """The content of the belt at a section."""

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
    """Why the node does nothing any more; empty: all is well."""
    stopped: str
    """The person who stopped the cell; empty: no person."""
    in_local: str
    """Only panels move the line; empty: everybody does who may."""
    stands: str
    """Why nothing moves; empty: something does, or another line says so."""
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
    """The commands to type where the cell stands and waits for a person."""
    troubles: tuple[str, ...]
    flags: tuple[str, ...]

    @property
    def is_held(self) -> bool:
        """Tell whether somebody has to decide something."""
        return bool(self.holds)


def cell_view(status: CellStatus, shell: Shell) -> CellView:
    """Return the view of a status.

    :param shell: for the command lines
    """
    return CellView(
        cell=one_line(status.cell),
        state=status.state.value,
        failure=words.failure(status),
        stopped=words.stopped(status),
        in_local=words.in_local(status),
        stands=words.stands(status),
        belt=words.belt(status),
        belt_waiting=tuple(words.reasons(status.belt.waits)),
        made_at=status.stamp,
        slots=tuple(_slot(section.slot) for section in status.sections),
        rows=tuple(row for section in status.sections for row in _rows(section, status)),
        initialization=tuple(words.reasons(status.initialization)),
        jobs=tuple(_job(job, status) for job in status.jobs),
        unlisted_jobs=words.unlisted(status),
        holds=tuple(
            HoldRow(words.hold_text(hold), tuple(words.advice(hold, status, shell)))
            for hold in status.holds
        ),
        next_lines=(*alike_lines(status, shell), *next_lines(status, shell)),
        troubles=tuple(words.troubles(status)),
        flags=tuple(map(words.flag_count, status.flags)),
    )


def _slot(item: ItemStatus | None) -> Slot:
    if item is None:
        return Slot('')
    return Slot(words.slot(item), item.rejected, bool(item.nonconforming))


def _rows(section: SectionStatus, status: CellStatus) -> Iterator[Row]:
    """Yield what a section does and what it waits for; at least one row.

    The first one says what is wrong with the item in the slot.
    """
    number, slot = section.number, words.slot(section.slot)
    fate = words.fate(section.slot)
    for task in section.running:
        elapsed_s = max(status.stamp - task.started, 0.0)
        text = '; '.join(filter(None, [fate, words.task(task)]))
        yield Row(number, slot, text, Weight.WORKING, elapsed_s)
        fate = ''
    weight = Weight.WAITING_WITH_ITEM if slot or section.item else Weight.WAITING
    if any(hold.section == number for hold in status.holds):
        weight = Weight.HELD
    if section.waits or not section.running:
        parts = [fate, words.finished(section), *words.reasons(section.waits)]
        reasons = '; '.join(filter(None, parts))
        yield Row(number, slot, reasons, weight, None)


def _job(job: JobStatus, status: CellStatus) -> JobRow:
    quantity = max(job.quantity, 1)
    ended = job.state in OVER
    weight = Weight.ENDED if ended else Weight.WORKING if job.started else Weight.WAITING
    return JobRow(
        id=one_line(job.id),
        script=one_line(script_words(job)),
        state=job.state.state,
        counts=job_count_words(job)
        + words.ending(job)
        + words.start_wait(job)
        + words.piece_wait(job)
        + words.lacks(job)
        + words.expected_finish(job, status),
        packed=min(job.left / quantity, 1.0),
        on_line=min(job.on_line / quantity, 1.0),
        weight=weight,
    )
