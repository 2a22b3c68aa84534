"""Which sections owe a turn in this beat (semantics 3.4), asked only where something changed."""

from __future__ import annotations

from collections.abc import Mapping

from bt_orchestrator.model.line import feeding_job, owes_turn
from bt_orchestrator.model.state import CellState


class Turns:
    """The answers of `model.line.owes_turn`, kept up with the events.

    The belt looks at every section after every step of every cycle; in a line of 200 sections that
    was a third of a settle.
    """

    def __init__(self, state: CellState) -> None:
        self._state = state
        self._touched = set(state.sections)
        self._owing: dict[int, str] = {}

    def touch(self, section: int) -> None:
        """Ask a section anew: its cycle, its turn or its slot has changed."""
        self._touched.add(section)

    def touch_all(self) -> None:
        """Ask every section anew: another beat, or whatever else may have changed."""
        self._touched.update(self._state.sections)

    def owing(self) -> Mapping[int, str]:
        """Return what each section still has to do, by its number in ascending order."""
        # Whether the source may begin hangs on jobs, holds and initialization as well.
        feeding = feeding_job(self._state)
        if feeding is not None:
            self._touched.add(feeding.job.script.source)
        self._touched.update(self._owing)
        for number in self._touched:
            owed = owes_turn(self._state, self._state.sections[number])
            if owed is not None:
                self._owing[number] = owed
            else:
                self._owing.pop(number, None)
        self._touched.clear()
        return {number: self._owing[number] for number in sorted(self._owing)}
