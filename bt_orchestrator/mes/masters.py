"""What WorkMasterID can name here: a script, or a recipe."""

from __future__ import annotations

from collections.abc import Set
from dataclasses import dataclass


@dataclass(frozen=True)
class Masters:
    """Names that are known; the cell decides about those that are not."""

    scripts: Set[str] = frozenset()
    recipes: Set[str] = frozenset()

    def knows(self, name: str) -> bool:
        """Tell whether there is something of this name."""
        return name in self.scripts or name in self.recipes

    def is_recipe(self, name: str) -> bool:
        """Tell whether a name is that of a recipe."""
        return name in self.recipes

    def fault(self, name: str) -> str | None:
        """Say why it is not clear what a name stands for; None: it is."""
        if name not in self.scripts or name not in self.recipes:
            return None
        return f'{name!r} is the name of a script and of a recipe; rename one of them'


SCRIPTS_ONLY = Masters()
"""Nothing is known of recipes."""
