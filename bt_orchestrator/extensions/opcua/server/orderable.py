"""The choices of an order, as far as there are files here: scripts and recipes."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Mapping, Sequence, Set
from pathlib import Path

from bt_orchestrator.script.declared import Declared
from bt_orchestrator.script.order_files import OrderFiles
from bt_orchestrator.script.orders.by_recipe import DeclaredRecipe

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
        scripts = {one.name: one for one in self._files.scripts()}
        return scripts, {one.name: one for one in self._files.recipes()}
