"""The recipes that an order can name, in folders; files that stay as they are are read once."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from bt_orchestrator.script.lookup import scripts_in
from bt_orchestrator.script.recipes.declared import declared_recipes
from bt_orchestrator.web.scripts.shelf import parameters


class RecipeShelf:
    """All calls come from the loop's thread; the folders are read in another one."""

    def __init__(self, folders: Sequence[Path] = ()) -> None:
        """Prepare; nothing is read."""
        self._folders = tuple(folders)
        self._stamps: tuple[tuple[Path, int, int], ...] | None = None
        self._listed: list[dict[str, Any]] = []

    async def listed(self) -> list[dict[str, Any]]:
        """Return the recipes by name, each with the parameters of its newest version."""
        stamps, listed = await asyncio.to_thread(self._read, self._stamps)
        if listed is not None:
            self._stamps, self._listed = stamps, listed
        return self._listed

    def _read(
        self, known: object
    ) -> tuple[tuple[tuple[Path, int, int], ...], list[dict[str, Any]] | None]:
        """Return how the files stand, and what they declare; None: they are as they were."""
        stamps = tuple(self._files())
        if stamps == known:
            return stamps, None
        found = declared_recipes(self._folders)
        return stamps, [
            {
                'name': one.name,
                'versions': list(one.versions),
                'parameters': parameters(one.params.values()),
            }
            for one in found
        ]

    def _files(self) -> Iterator[tuple[Path, int, int]]:
        for path in (path for folder in self._folders for path in scripts_in(folder)):
            try:
                about = path.stat()
            except OSError:
                continue
            yield path, about.st_mtime_ns, about.st_size
