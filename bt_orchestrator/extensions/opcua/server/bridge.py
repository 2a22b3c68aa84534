"""Between the node and the server: what is heard goes to the parts, what is called to the node."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import time
from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from bt_orchestrator.base.errors import NodeUnreachable
from bt_orchestrator.extensions.opcua.server.calls import Calls
from bt_orchestrator.extensions.opcua.server.space import Space
from bt_orchestrator.extensions.opcua.server.values import Values
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.plant.shifts import PlantReason
from bt_orchestrator.model.status import CellDescription, CellStatus
from bt_orchestrator.ports import Records
from bt_orchestrator.ports.doors.cell_client import CellClient
from bt_orchestrator.ports.doors.following_door import Began, Fact, Happened
from bt_orchestrator.ports.doors.known import Known, told_by
from bt_orchestrator.ports.doors.open_door import OpenDoor
from bt_orchestrator.script.declared import Declared, OrderFiles
from bt_orchestrator.script.orders.by_recipe import DeclaredRecipe

log = logging.getLogger(__name__)

LOOK_S = 0.5
"""Between two looks at whether the node is silent."""


@dataclass(frozen=True)
class Sources:
    """Other sources of the server; each may be missing."""

    trees: Sequence[Path] = ()
    """Folders in which scripts are looked up by name."""
    recipes: Sequence[Path] = ()
    """Folders in which recipes are looked up by name."""
    nodesets: Path | None = None
    """Folder of a site's own nodesets."""
    reasons: Mapping[str, PlantReason] = field(default_factory=dict)
    """Of the plant for stops, by code."""
    open_records: Callable[[], Records] | None = None
    """Opens the journal, to be read in the thread that calls it; None: the door tells the past."""


class Bridge(CellClient):
    """States: made, started, ended. All but the constructor is called in the server's loop."""

    def __init__(self, node: str, open_door: OpenDoor, sources: Sources | None = None) -> None:
        """Put the parts together; nothing is started.

        :param node: full name of the node
        """
        super().__init__('opcua', node, open_door)
        self.sources = sources or Sources()
        self.known = Known()
        self.orderable = Orderable(self.sources.trees, self.sources.recipes)
        self.history = ''
        """Empty: nothing was heard yet."""
        self.newest = 0
        """The last event that was heard of."""
        self.other_cell = asyncio.Event()
        """The cell differs from the one that the parts were built for."""
        self._status: CellStatus | None = None
        self._description: CellDescription | None = None
        self._begins_at = 0
        """Events up to this one were before us."""
        self._must_describe = True
        """The node may have started anew, with another cell file."""
        self._caught_up = asyncio.Event()
        self._held_back: list[Fact] | None = None
        """The news while parts are built; None: no parts are being built."""
        self._parts: Sequence[Part] = ()
        self._values: Values | None = None

    def _newest(self) -> int:
        return self.newest

    def _prepare(self) -> None:
        self.calls = Calls(self.tickets)
        self._spawn(self._look())

    async def caught_up(self) -> None:
        """Wait until it is known how the cell stands."""
        await self._caught_up.wait()

    @property
    def status(self) -> CellStatus:
        """The newest one; there is one once it has caught up."""
        assert self._status is not None
        return self._status

    @property
    def description(self) -> CellDescription:
        """The description of the cell; known once it has caught up."""
        assert self._description is not None
        return self._description

    def hold_back(self) -> None:
        """Let nothing change until `serve`.

        Parts are built from one status, which takes seconds, and hear every event after it.
        """
        self.other_cell.clear()
        self._held_back = []

    def serve(self, parts: Sequence[Part], values: Values) -> None:
        """Tell parts, which have been built, everything since `hold_back`, and from now on."""
        self._parts, self._values = parts, values
        facts, self._held_back = self._held_back or [], None
        self._show()
        self._take(facts)

    def leave(self) -> None:
        """Tell the parts nothing more."""
        self._parts, self._values = (), None

    # --- what is heard ----------------------------------------------------------------------

    def _take(self, facts: Sequence[Fact]) -> None:
        if self._held_back is not None:
            self._held_back += facts
            return
        for fact in facts:
            if isinstance(fact, CellStatus):
                self._take_status(fact)
            elif isinstance(fact, Began):
                self._begin(fact)
            else:
                self.newest = fact.last
                if isinstance(fact, Happened):
                    self.known.hear(fact.event)
                    for part in self._parts:
                        _guarded(part.hear, fact.event)

    def _begin(self, began: Began) -> None:
        self.history, self.newest = began.history, began.last
        self._begins_at = began.last
        self._must_describe = True
        self.known.begin()
        for part in self._parts:
            _guarded(part.begin, began.history)

    def _take_status(self, status: CellStatus) -> None:
        if status.history != self.history:
            return  # of a node that is gone
        self.newest = max(self.newest, status.seq)
        self._status = status
        if self._must_describe:
            self._must_describe = False
            self._spawn(self._describe())
        if self._values is not None and not self.doors.is_silent:
            self._values.trust()
        self._show()

    def _show(self) -> None:
        for part in self._parts:
            _guarded(part.show, self.status)

    async def _describe(self) -> None:
        """Ask what exists, and what events of before us have told."""
        try:
            description = await self.doors.description()
            with contextlib.suppress(KeyError, TypeError, ValueError):  # of another version
                self.known.take(await self.doors.read(lambda door: told_by(door.moment())))
        except NodeUnreachable:
            self._must_describe = True  # with the next status
            return
        if description != self._description:
            self._description = description
            self.other_cell.set()
        if self.status.seq >= self._begins_at:
            self._caught_up.set()
        else:
            self._must_describe = True

    async def _look(self) -> None:
        while True:
            await asyncio.sleep(LOOK_S)
            if self.doors.is_silent:
                self._must_describe = True
                if self._values is not None:
                    self._values.doubt()


def _guarded(tell: Callable[..., object], fact: object) -> None:
    """Tell a part something; a mistake in one part must not silence the others."""
    try:
        tell(fact)
    except Exception:
        log.exception('defect: a part of the server could not take %s', type(fact).__name__)


# The choices of an order, as far as there are files here: scripts and recipes.

LOOK_AGAIN_S = 30.0
"""Between two looks at the folders."""

SOON_S = 1.0
"""The same where somebody names what is not known yet."""


class Orderable:
    """All calls come from the server's loop; the folders are read in another thread."""

    def __init__(self, trees: Sequence[Path], recipes: Sequence[Path]) -> None:
        """Prepare; nothing is read.

        :param trees: folders of scripts
        :param recipes: folders of recipes
        """
        self._files = OrderFiles(trees, recipes)
        self.scripts: Mapping[str, Declared] = {}
        self.recipes: Mapping[str, DeclaredRecipe] = {}
        self.looked_at: float | None = None
        """By the monotonic clock; None: not yet."""

    @property
    def is_due(self) -> bool:
        """Tell whether it is time to look again."""
        return self._is_old(LOOK_AGAIN_S)

    async def look(self) -> None:
        """Read the folders."""
        self.looked_at = time.monotonic()
        self.scripts, self.recipes = await asyncio.to_thread(self._read)

    async def recipe_names(self, wanted: str) -> Set[str]:
        """Return the names of recipes that no script has: of both, an order names the script.

        :param wanted: a name; if it is new, the folders are read again
        """
        is_new = wanted not in self.scripts and wanted not in self.recipes
        if is_new and self._is_old(SOON_S):
            await self.look()
        return self.recipes.keys() - self.scripts.keys()

    def _is_old(self, seconds: float) -> bool:
        return self.looked_at is None or time.monotonic() >= self.looked_at + seconds

    def _read(self) -> tuple[Mapping[str, Declared], Mapping[str, DeclaredRecipe]]:
        scripts = {script.name: script for script in self._files.scripts()}
        return scripts, {recipe.name: recipe for recipe in self._files.recipes()}


# The work of each part of the server: the flat one, job control, PackML, holds.


class Part(Protocol):
    """A part of the address space. All calls come from the server's loop.

    It lives as long as what exists in the cell stays the same; for another cell file it is made
    anew, and clients connect again.
    """

    async def build(self, space: Space) -> None:
        """Make the nodes and methods; no client is there yet, and the status is known."""

    def show(self, status: CellStatus) -> None:
        """Show a new status (`Values.put`); first right after `build`."""

    def hear(self, event: Event) -> None:
        """Take note of an event: each one since `build`, once and in order."""

    def begin(self, history: str) -> None:
        """Forget what was: the cell has another journal. Its status is shown next."""
