"""Knowledge beside the status: scripts by digest, orders of jobs, the cell."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.jobs.order import RecipeChoice
from bt_orchestrator.model.keeping.snapshot import state_from_plain
from bt_orchestrator.model.script import Script
from bt_orchestrator.ports import Moment


class Ordered(NamedTuple):
    """The parts of an order that no status has."""

    params: Mapping[str, object]
    choice: RecipeChoice | None
    """The recipe that it named in place of a script; None: it named a script."""


MOST_SCRIPTS = 100
"""Scripts that are kept; those of listed jobs beyond that."""

MOST_ORDERS = 20_000
"""Jobs whose orders are kept."""


@dataclass(frozen=True)
class Told:
    """The facts of a moment of the cell."""

    cell: Cell
    scripts: Mapping[str, Script]
    """Of live jobs, by digest."""
    orders: Mapping[str, Ordered]
    """By job."""


def told_by(moment: Moment) -> Told:
    """Read a moment; this may take some tenths of a second.

    :raises KeyError: it does not fit its cell
    :raises TypeError: it is of a newer version
    :raises ValueError: the same
    """
    state = state_from_plain(moment.cell, moment.plain_state)
    jobs = {name: job.job for name, job in state.jobs.items()}
    orders = {name: Ordered(job.params, job.recipe) for name, job in jobs.items()}
    return Told(moment.cell, dict(state.scripts), orders)


class Known:
    """Grows with what is heard. All calls come from the loop's thread."""

    def __init__(self) -> None:
        self.scripts: dict[str, Script] = {}
        """By digest; one says what it is, whatever journal it came from."""
        self.orders: dict[str, Ordered] = {}
        """By job."""
        self.cell: Cell | None = None
        self._looked_for: set[str] = set()

    def begin(self) -> None:
        """Forget the jobs: the cell has another journal, and perhaps another cell file."""
        self.orders.clear()
        self.cell = None
        self._looked_for.clear()

    def hear(self, event: Event) -> None:
        """Take note of an event."""
        if isinstance(event, e.ScriptLoaded):
            self.scripts[event.digest] = event.definition
        elif isinstance(event, e.OrderEvent):
            self.orders[event.job] = Ordered(event.params, event.choice)
            if len(self.orders) > MOST_ORDERS:
                del self.orders[next(iter(self.orders))]

    def take(self, news: Told) -> None:
        """Take in what a moment tells."""
        self.cell = news.cell
        self.scripts |= news.scripts
        self.orders |= news.orders

    def lacks(self, digests: Iterable[str]) -> bool:
        """Tell whether a script is not known that was not asked for before.

        A moment tells the scripts of live jobs alone, so one that it lacks is not asked for again.

        :param digests: of all scripts that are shown now; of the others the oldest are forgotten
        """
        shown = {digest for digest in digests if digest}
        for old in [script for script in self.scripts if script not in shown][:-MOST_SCRIPTS]:
            del self.scripts[old]
        new = shown - self.scripts.keys() - self._looked_for
        self._looked_for |= new
        return bool(new)

    def not_told(self) -> None:
        """Ask again: the node did not answer."""
        self._looked_for.clear()
