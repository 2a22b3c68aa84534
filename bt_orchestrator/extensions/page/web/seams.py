"""The needs of the parts of the page from each other, as Protocols: each is made on its own."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.plant.shifts import PlantReason, Shifts
from bt_orchestrator.model.status import CellDescription, CellStatus
from bt_orchestrator.ports import Planning, Records
from bt_orchestrator.ports.records import PlantCells


@dataclass(frozen=True)
class Plant:
    """When the cell is meant to work, and how quickly."""

    shifts: Shifts
    cell: Cell | None
    """For the pace; None: there is no performance and no OEE."""
    reasons: Mapping[str, PlantReason] = field(default_factory=dict)
    """Of the plant for stops, by code."""


@dataclass(frozen=True)
class Sources:
    """Other sources of the page; each may be missing."""

    open_records: Callable[[], Records] | None = None
    """Opens the journal; raises JournalUnusable. None: the past is what the node tells."""
    trees: Sequence[Path] = ()
    """Folders in which scripts are looked up by name."""
    recipes: Sequence[Path] = ()
    """Folders in which recipes are looked up by name."""
    planning: Planning | None = None
    """Works out what-if and checks orders; the page closes it."""
    plant: Plant | None = None
    """For the account of the shift that runs; None: it is not shown."""
    reasons: Mapping[str, PlantReason] = field(default_factory=dict)
    """Of the plant for stops, by code; forms offer them."""
    cells: PlantCells | None = None
    """Reads the list of cells of the plant; None: it is not shown."""


class SeenCell(Protocol):
    """The cell as the page has heard of it last."""

    @property
    def status(self) -> CellStatus | None:
        """The newest one; None: nothing was heard."""

    @property
    def description(self) -> CellDescription | None:
        """The description of the cell; None: not known yet."""


class Show(Protocol):
    """Decides what the page shows of a cell. All calls come from the loop's thread."""

    wants_moment: bool
    """A moment of the cell would tell more than is shown; whoever asks for one clears it."""

    def begin(self, history: str) -> None:
        """Forget what was known: the cell has another journal, or is seen for the first time."""

    def hear(self, event: Event) -> None:
        """Take note of an event; every one since the page began, once and in order."""

    def parts(
        self, status: CellStatus, description: CellDescription | None, node: str
    ) -> Mapping[str, object]:
        """Return everything that is shown, by key (`cell`, `section/4`, `job/WO-1`).

        Called only when a status has come and somebody looks. Values are what JSON can carry; a
        part that equals the one before is not sent again.

        :param description: None: not known yet
        """
