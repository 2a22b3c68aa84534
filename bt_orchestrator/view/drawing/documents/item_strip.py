"""The time of one item as a Gantt chart: a row a section, with its attempts, waits and holds."""

from __future__ import annotations

from collections import defaultdict

from bt_orchestrator.model.events import TaskKey
from bt_orchestrator.model.hold_words import again_words
from bt_orchestrator.model.wait import WaitKind
from bt_orchestrator.view.drawing.gantt import CycleBar, Gantt, HoldBar, Row, TaskBar
from bt_orchestrator.view.report.item.history import FAILED, Attempt, Held, ItemHistory, Waited
from bt_orchestrator.view.report.wait_log import Cause, WaitSpan

CELL = 'cell'
"""The row of holds of the whole cell, and of restarts."""


def item_strip(history: ItemHistory, until: float) -> Gantt:
    """Return the chart of an item.

    :param until: where it ends if the item has not ended
    """
    begin = history.started if history.started is not None else until
    end = max(history.ended if history.ended is not None else until, begin)
    rows: dict[str, Row] = {
        f'section {n}': Row(f'section {n}') for n in sorted(_sections(history))
    }
    waits: dict[str, list[WaitSpan]] = defaultdict(list)
    for attempt in history.tasks:
        row = rows[_row(attempt.section)]
        if attempt.started is not None:
            row.tasks.append(_bar(history, attempt, end))
        waits[row.title] += map(_wait, attempt.waited)
    sections = {attempt.task: attempt.section for attempt in history.tasks}
    for held in history.holds:
        title = CELL if held.of_cell or held.task not in sections else _row(sections[held.task])
        rows.setdefault(title, Row(title)).holds.append(_hold(held, end))
    for stay in history.stays:
        row = rows.setdefault(_row(stay.section), Row(_row(stay.section)))
        row.cycles.append(CycleBar(history.job, history.item, stay.since, stay.until or end))
    for title, spans in waits.items():
        rows[title].waits = _apart(spans, rows[title])
    ordered = [rows[title] for title in sorted(rows, key=_order)]
    title = f'{history.item}, section by section'
    return Gantt('', end - begin, (history.job,), tuple(ordered), begin, is_past=True, title=title)


def _sections(history: ItemHistory) -> set[int]:
    numbers = [task.section for task in history.tasks]
    numbers += [stay.section for stay in history.stays]
    return {number for number in numbers if number is not None}


def _order(title: str) -> tuple[bool, int]:
    number = title.rpartition(' ')[2]
    return (title != CELL, int(number) if number.isdecimal() else 0)


def _row(section: int | None) -> str:
    return f'section {section}'


def _bar(history: ItemHistory, attempt: Attempt, end: float) -> TaskBar:
    outcome = attempt.reason if attempt.outcome == FAILED else attempt.outcome
    return TaskBar(
        TaskKey(history.job, attempt.section, history.item, attempt.task),
        attempt.name,
        attempt.component,
        again_words(attempt.round, attempt.attempt),
        attempt.started or 0.0,
        end if attempt.ended is None else attempt.ended,
        'runs' if attempt.ended is None else outcome,
    )


def _hold(held: Held, end: float) -> HoldBar:
    return HoldBar(held.id, held.words, held.time, end if held.ended is None else held.ended)


def _wait(waited: Waited) -> WaitSpan:
    kind = WaitKind(waited.kind) if waited.kind else WaitKind.CELL_STATE
    return WaitSpan(
        waited.start, waited.end, (Cause(kind, waited.words or 'not told by the journal'),)
    )


def _apart(spans: list[WaitSpan], row: Row) -> list[WaitSpan]:
    """Return the waits in which nothing of the row ran: parallel tasks wait for themselves."""
    work = sorted((bar.start_s, bar.end_s) for bar in row.tasks)
    return [
        span
        for span in dict.fromkeys(spans)
        if not any(start < span.end_s and span.start_s < end for start, end in work)
    ]
