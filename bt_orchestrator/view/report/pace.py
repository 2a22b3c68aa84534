"""Estimates of when jobs end, from the durations of a cell (semantics 8.4).

A line that is full keeps its pace. Waits for what there is only one of, faults and people make it
slower, and a line that fills or drains is not full; a forecast takes them into account and this
does not.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.jobs.needs import awaited_by
from bt_orchestrator.model.limits import QUEUE_SHOWN
from bt_orchestrator.model.proof.pace import Durations, PacedLine
from bt_orchestrator.model.state import CellState, JobState


class Paces:
    """Seconds from one item to the next, of scripts by their digests.

    Each is worked out again only when the durations of its tasks have changed.
    """

    def __init__(self) -> None:
        self._lines: dict[str, PacedLine] = {}
        self._known: dict[str, tuple[Durations, float]] = {}

    def item_s(self, job: JobState, cell: Cell) -> float:
        """Return it for the script of a job; infinite if the line gets stuck with it.

        :param cell: the one that the script is for, perhaps with other durations
        """
        line = self._lines.get(job.digest)
        if line is None:
            line = self._lines[job.digest] = PacedLine(job.job.script, cell)
        if line.gets_stuck:
            return math.inf
        us = line.durations(cell)
        known = self._known.get(job.digest)
        if known is None or known[0] != us:
            known = self._known[job.digest] = us, line.limit(us).per_item_s
        return known[1]

    def keep(self, digests: Collection[str]) -> None:
        """Forget all other scripts."""
        for digest in self._lines.keys() - digests:
            del self._lines[digest]
            self._known.pop(digest, None)


def expected_ends_s(
    state: CellState, cell: Cell, paces: Paces | None = None
) -> Mapping[str, float]:
    """Return in how many seconds active and next jobs end, if nothing stops the line.

    Left out are jobs that may not start, are paused or need a component that is out of service,
    what waits behind such a job on the line, and those far back in a long queue.

    :param cell: the one of the state, perhaps with other durations
    :param paces: those of earlier estimates for this cell
    """
    if not state.packml.begins or state.stop_after is not None:
        return {}
    paces = Paces() if paces is None else paces
    ends: dict[str, float] = {}
    feed_s = 0.0
    paces_s: dict[str, float] = {}
    for job in state.jobs.first(QUEUE_SHOWN):
        if job.paused or (job.started and awaited_by(state, job)):
            break
        if job.started or job.may_start or job.ending:
            if job.digest not in paces_s:
                paces_s[job.digest] = paces.item_s(job, cell)
            pace_s = paces_s[job.digest]
            if math.isinf(pace_s):
                break
            feed_s += job.cycles_left * pace_s
            ends[job.job.id] = max([feed_s + way for way in _ways_s(job, pace_s)], default=feed_s)
    paces.keep(paces_s)
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
