"""What is known beside the status: scripts by digest, parameters of jobs, the cell."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.keeping.snapshot import state_from_plain
from bt_orchestrator.model.script import Script
from bt_orchestrator.ports import Moment

Params = Mapping[str, Mapping[str, object]]

MOST_SCRIPTS = 100
"""Scripts that are kept; those of listed jobs beyond that."""

MOST_PARAMS = 20_000
"""Jobs whose parameters are kept."""


@dataclass(frozen=True)
class Told:
    """What a moment of the cell tells."""

    cell: Cell
    scripts: Mapping[str, Script]
    """Of live jobs, by digest."""
    params: Params
    """By job."""


def told_by(moment: Moment) -> Told:
    """Read a moment; this may take some tenths of a second.

    :raises KeyError: it does not fit its cell
    :raises TypeError: it is of a newer version
    :raises ValueError: the same
    """
    state = state_from_plain(moment.cell, moment.plain_state)
    params = {name: job.job.params for name, job in state.jobs.items()}
    return Told(moment.cell, dict(state.scripts), params)


class Known:
    """Grows with what is heard. All calls come from the loop's thread."""

    def __init__(self) -> None:
        self.scripts: dict[str, Script] = {}
        """By digest; one says what it is, whatever journal it came from."""
        self.params: dict[str, Mapping[str, object]] = {}
        """By job."""
        self.cell: Cell | None = None
        self._looked_for: set[str] = set()

    def begin(self) -> None:
        """Forget the jobs: the cell has another journal, and perhaps another cell file."""
        self.params.clear()
        self.cell = None
        self._looked_for.clear()

    def hear(self, event: Event) -> None:
        """Take note of an event."""
        if isinstance(event, e.ScriptLoaded):
            self.scripts[event.digest] = event.definition
        elif isinstance(event, (e.JobQueued, e.JobUpdated)):
            self.params[event.job] = event.params
            if len(self.params) > MOST_PARAMS:
                del self.params[next(iter(self.params))]

    def take(self, told: Told) -> None:
        """Take in what a moment tells."""
        self.cell = told.cell
        self.scripts |= told.scripts
        self.params |= told.params

    def lacks(self, digests: Iterable[str]) -> bool:
        """Tell whether a script is not known that was not asked for before.

        A moment tells the scripts of live jobs alone, so one that it lacks is not asked for again.

        :param digests: of all scripts that are shown now; of the others the oldest are forgotten
        """
        shown = {one for one in digests if one}
        for old in [one for one in self.scripts if one not in shown][:-MOST_SCRIPTS]:
            del self.scripts[old]
        new = shown - self.scripts.keys() - self._looked_for
        self._looked_for |= new
        return bool(new)

    def not_told(self) -> None:
        """Ask again: the node did not answer."""
        self._looked_for.clear()
