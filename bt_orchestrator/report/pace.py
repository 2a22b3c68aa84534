"""Estimates of when jobs end, from the durations of a cell (semantics 8.3).

The steady pace of a line is that of its slowest section. Flags, shared components, faults and
people make it slower; `simulate` takes them into account and this does not.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.limits import QUEUE_SHOWN
from bt_orchestrator.model.script import Script, SectionList, Step
from bt_orchestrator.model.state import CellState, JobState


def item_s(script: Script, cell: Cell) -> float:
    """Return the seconds between two items of a script, by the durations of a cell."""
    move_s = cell.conveyor.component.duration_s(cell.conveyor.task)
    return max(max(periods(tasks, cell, move_s)) for tasks in script.sections.values())


def periods(tasks: SectionList, cell: Cell, move_s: float) -> Iterator[float]:
    """Yield the least seconds between two cycles of a section: its whole list, and a beat.

    A beat is the move and what needs the belt at rest; leading steps run while it moves (3.7).
    """
    yield _sum_s(tasks.steps, cell)
    in_turn = tasks.steps[: tasks.turn_steps]
    lead = next((n for n, step in enumerate(in_turn) if step.requires_conveyor), len(in_turn))
    yield move_s + _sum_s(in_turn[lead:], cell)


def expected_ends_s(state: CellState, cell: Cell) -> Mapping[str, float]:
    """Return in how many seconds active and next jobs end, if nothing stops the line.

    Jobs that are held or paused, what waits behind a paused one, and those far back in a long
    queue are left out.

    :param cell: the one of the state, perhaps with other durations
    """
    if not state.packml.begins or state.stop_after is not None:
        return {}
    ends: dict[str, float] = {}
    feed_s = 0.0
    paces_s: dict[str, float] = {}
    for job in state.jobs.first(QUEUE_SHOWN):
        if job.paused:
            break
        if not job.held:
            if job.digest not in paces_s:
                paces_s[job.digest] = item_s(job.job.script, cell)
            pace_s = paces_s[job.digest]
            feed_s += job.cycles_left * pace_s
            ends[job.job.id] = max([feed_s + way for way in _ways_s(job, pace_s)], default=feed_s)
    return ends


def _ways_s(job: JobState, pace_s: float) -> Iterator[float]:
    """Yield how long items take to the sink: the one to begin last, else those on the line."""
    script = job.job.script
    if job.cycles_left:
        yield (script.sink - script.source) * pace_s
        return
    for item in job.items.values():
        at = item.section or script.source
        yield max(script.sink - at + 1, 0) * pace_s


def _sum_s(steps: Iterable[Step], cell: Cell) -> float:
    return sum(max(_track_s(step, cell)) for step in steps)


def _track_s(step: Step, cell: Cell) -> list[float]:
    return [
        sum(cell.components[task.component].duration_s(task.name) for task in track)
        for track in step.tracks
    ]
