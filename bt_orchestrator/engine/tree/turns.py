"""The sections that owe a turn in this beat (semantics 3.4), computed only after changes."""

from __future__ import annotations

from collections.abc import Mapping

from bt_orchestrator.model.line import feeding_job, owes_turn
from bt_orchestrator.model.state import CellState


class Turns:
    """Cache of `model.line.owes_turn`, updated by the events.

    The belt checks every section after every step of every cycle; in a line of 200 sections that
    was a third of a settle.
    """

    def __init__(self, state: CellState) -> None:
        self._state = state
        self._touched = set(state.sections)
        self._owing: dict[int, str] = {}

    def touch(self, section: int) -> None:
        """Invalidate a section: its cycle, its turn or its slot has changed."""
        self._touched.add(section)

    def touch_all(self) -> None:
        """Invalidate every section: the beat or anything else has changed."""
        self._touched.update(self._state.sections)

    def owing(self) -> Mapping[int, str]:
        """Return what each section still has to do, by its number, ascending."""
        # Whether the source may begin depends also on jobs, holds and initialization.
        feeding = feeding_job(self._state)
        if feeding is not None:
            self._touched.add(feeding.job.script.source)
        state, owing = self._state, self._owing
        self._touched.update(owing)
        for number in self._touched:
            owed = owes_turn(state, state.sections[number])
            if owed is not None:
                owing[number] = owed
            elif number in owing:
                del owing[number]
        self._touched.clear()
        return dict(sorted(owing.items())) if len(owing) > 1 else owing
