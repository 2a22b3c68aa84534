"""Hides what `WITHOUT` names from each Python that starts with this folder on its path."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence


class Blocker:
    """Finds nothing of some modules, as if nobody had installed them."""

    def __init__(self, modules: Sequence[str]) -> None:
        self._modules = modules

    def find_spec(self, name: str, path: object = None, target: object = None) -> None:
        """Raise what Python raises where a module is missing."""
        if any(name == module or name.startswith(f'{module}.') for module in self._modules):
            raise ModuleNotFoundError(f'No module named {name!r}', name=name)


sys.meta_path.insert(0, Blocker(os.environ.get('WITHOUT', '').split()))
